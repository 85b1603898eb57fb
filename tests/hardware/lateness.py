"""How late the machine wakes who sleeps: what is held to deadlines says nothing of the code where the machine itself missed them."""

import threading
import time

__all__ = ["Lateness"]

#: of a sleep, s; and how much later than that a thread may wake on a machine that has time
SLEEP, ALLOWED = 0.01, 0.02


class Lateness:
    """Sleeps again and again in a thread of its own, and keeps by how much it woke too late at most."""

    def __init__(self):
        self._most = 0.0
        self._thread = threading.Thread(target=self._go_on, daemon=True, name="lateness")

    def begin(self):
        """Forget what was, and go on from now."""
        self._most = 0.0
        if not self._thread.is_alive():
            self._thread.start()

    def was_late(self):
        """Return whether the machine was late since it was last begun."""
        return self._most > ALLOWED

    def _go_on(self):
        while True:
            due = time.monotonic() + SLEEP
            time.sleep(SLEEP)
            self._most = max(self._most, time.monotonic() - due)
