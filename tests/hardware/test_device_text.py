"""What a device says is shown to people, and no terminal may obey it."""

import socket
import threading

from hypothesis import given
from hypothesis import strategies as st

from stretch_bt.hardware.device_text import device_text
from stretch_bt.hardware.ur.dashboard import ask_dashboard


@given(st.binary(max_size=2000))
def test_it_is_one_line_that_can_be_printed(data):
    told = device_text(data)
    assert told.isprintable()
    assert len(told) <= 203


def test_a_dashboard_that_sends_control_characters_moves_no_cursor():
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            connection, _ = server.accept()
            with connection:
                connection.sendall(b"Connected: Universal Robots Dashboard Server\n")
                connection.recv(100)
                connection.sendall(b"\x1b]0;owned\x07\x1b[2Jok  arm: all is well\n")
                connection.recv(100)

        thread = threading.Thread(target=serve)
        thread.start()
        [answer] = ask_dashboard("127.0.0.1", ["robotmode"], 2.0, port=server.getsockname()[1])
        thread.join()
    assert answer == "\\x1b]0;owned\\x07\\x1b[2Jok  arm: all is well"
