"""A gripper by Modbus, through pymodbus: RTU on a serial line, RTU through a TCP gateway, or Modbus TCP."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from stretch_bt.errors import InvalidInput, MissingExtra
from stretch_bt.hardware.robotiq.registers import COUNT, READ_FROM, WRITE_TO, Command, Status
from stretch_bt.hardware.wire_thread import WireClosed, WireError, WrongAnswer

if TYPE_CHECKING:
    from pymodbus.client import ModbusSerialClient, ModbusTcpClient
    from pymodbus.pdu import ModbusPDU

    Client = ModbusTcpClient | ModbusSerialClient

__all__ = ["ModbusWire", "serial_client", "tcp_client"]

_TRIES = 2


class ModbusWire:
    """One exchange at a time.

    RTU frames carry no number, so an answer that comes too late would pass for the answer to the next question. Therefore pymodbus
    never repeats a request by itself here: after an answer that is missing or broken the connection is closed, which drops
    what may still come, and the exchange is tried once more on a new one. A connection that the other side closed is lost.
    """

    exchanges = 1

    def __init__(self, make: Callable[[], Client], unit: int, read_function: int = 4) -> None:
        self._make = make
        self._unit = unit
        self._read_function = read_function
        self._client: Client | None = None

    def connect(self) -> None:
        """Connect; raises WireError."""
        if self._client is None:
            self._client = self._make()
        if not self._client.connect():
            raise WireError(f"cannot connect to {self._client.comm_params.host}")

    def close(self) -> None:
        """Disconnect."""
        client, self._client = self._client, None
        if client is not None:
            with suppress(OSError):
                client.close()  # type: ignore[no-untyped-call]

    def read(self) -> Status:
        """Read the three status registers."""

        def ask(client: Client) -> ModbusPDU:
            read = client.read_input_registers if self._read_function == 4 else client.read_holding_registers
            return read(READ_FROM, count=COUNT, device_id=self._unit)

        reply = self._exchange(ask, self._read_function)
        try:
            return Status.decode(reply.registers)
        except InvalidInput as error:
            check = "check `read_function` and `unit`, and that this is a 2F gripper"
            raise WrongAnswer(f"{error}; {check}") from None

    def go(self, position: int, speed: int, force: int) -> None:
        """Send the fingers to a count."""
        self._write(Command(activate=True, go=True, position=position, speed=speed, force=force))

    def hold(self, status: Status) -> None:
        """End a motion where the fingers are."""
        self._write(Command(activate=True, position=status.echo))

    def reset(self) -> None:
        """Clear faults and activation."""
        self._write(Command(activate=False))

    def activate(self) -> None:
        """Begin the activation."""
        self._write(Command(activate=True))

    def _write(self, command: Command) -> None:
        values = command.encode()
        reply = self._exchange(lambda c: c.write_registers(WRITE_TO, values, device_id=self._unit), 16)
        if (reply.address, reply.count) != (WRITE_TO, COUNT):
            raise WireError(
                f"it confirmed {reply.count} registers at {reply.address:#06x}, not those that were written"
            )

    def _exchange(self, ask: Callable[[Client], ModbusPDU], function: int) -> Any:
        for left in reversed(range(_TRIES)):
            try:
                return self._once(ask, function)
            except WireError as error:
                self.close()
                if not left or isinstance(error, WireClosed):
                    raise
        raise AssertionError("not reached")

    def _once(self, ask: Callable[[Client], ModbusPDU], function: int) -> ModbusPDU:
        from pymodbus import ModbusException
        from pymodbus.exceptions import ConnectionException

        self.connect()
        assert self._client is not None
        try:
            reply = ask(self._client)
        except (ConnectionException, ConnectionError) as error:
            raise WireClosed(_plain(error)) from error
        except (ModbusException, OSError) as error:
            raise WireError(_plain(error)) from error
        except (ValueError, IndexError, KeyError, TypeError, AttributeError) as error:
            raise WireError(
                f"an answer that is no Modbus ({error})"
            ) from error  # the client trips over some broken frames
        if reply.isError():
            raise WireError(f"it refused the request with Modbus exception {getattr(reply, 'exception_code', '?')}")
        if reply.function_code != function:
            raise WireError(f"it answered function {reply.function_code} to a request for {function}")
        return reply


def tcp_client(host: str, port: int, framing: str, timeout: float) -> Client:
    """Return a client for Modbus TCP, or for RTU through a gateway; opens nothing."""
    _quieten()
    from pymodbus import FramerType
    from pymodbus.client import ModbusTcpClient

    framer = FramerType.RTU if framing == "rtu" else FramerType.SOCKET
    return ModbusTcpClient(host, port=port, framer=framer, timeout=timeout, retries=0)


def serial_client(port: str, baudrate: int, timeout: float) -> Client:
    """Return a client for RTU on a serial line, 8 data bits, no parity, 1 stop bit; opens nothing."""
    _quieten()
    if find_spec("serial") is None:
        raise MissingExtra("a gripper on a serial line needs pyserial; install it with: pip install pyserial")
    from pymodbus.client import ModbusSerialClient

    return ModbusSerialClient(port, baudrate=baudrate, timeout=timeout, retries=0)


def _quieten() -> None:
    """Keep pymodbus from printing what is raised anyway."""
    try:
        from pymodbus import logging as chatter
    except ImportError:
        raise MissingExtra(
            "a gripper by Modbus needs pymodbus; install it with: pip install 'pymodbus>=3.13,<4'"
        ) from None
    logging.getLogger(chatter.__name__).setLevel(logging.CRITICAL)


def _plain(error: Exception) -> str:
    """Return what a client says without its own address in memory."""
    text = str(error)
    if "Connection" in text:
        return "the other side closed the connection"
    if "No response received" in text:
        return "no answer, or a broken one, within the time of an exchange"
    if "Unable to decode" in text:
        return "an answer that is no Modbus"
    return text.removeprefix("Modbus Error: ").removeprefix("[Input/Output] ") or type(error).__name__
