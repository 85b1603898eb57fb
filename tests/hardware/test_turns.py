"""The lock that the stand-ins of a scene have in turn."""

import threading
import time

from stretch_bt.hardware.emulators.turns import Turns


def test_it_is_had_in_the_order_of_coming_and_by_its_owner_again():
    turns, order = Turns(), []

    def take(name):
        with turns:
            order.append(name)

    with turns, turns:
        waiting = []
        for name in "abc":
            thread = threading.Thread(target=take, args=(name,))
            thread.start()
            waiting.append(thread)
            while len(turns._waiting) < len(waiting):
                time.sleep(0.001)
    with turns:  # comes after all that waited
        order.append("last")
    for thread in waiting:
        thread.join()
    assert order == ["a", "b", "c", "last"]


def test_one_has_it_at_a_time():
    turns, inside, most = Turns(), [0], [0]

    def take():
        for _ in range(200):
            with turns:
                inside[0] += 1
                most[0] = max(most[0], inside[0])
                time.sleep(0)
                inside[0] -= 1

    threads = [threading.Thread(target=take) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1]
    assert turns._owner is None
