"""How a run ended: its status, its reason, and what else went wrong on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from stretch_bt.blame import Broken, blame
from stretch_bt.errors import DeviceFault, StretchError, named, writable
from stretch_bt.runtime.cut_off import CutOff

__all__ = ["Outcome", "reason_of", "status_of"]


@dataclass(slots=True)
class Outcome:
    """How a run ended."""

    status: str = "ERROR"
    reason: str = ""
    ticks: int = 0
    task_seconds: float = 0.0
    wall_seconds: float = 0.0
    cpu_seconds: float = 0.0
    overruns: int = 0
    worst_overrun: float = 0.0
    errors: list[str] = field(default_factory=list)
    broken: list[Broken] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def end(self, status: str, reason: str) -> None:
        """End so."""
        self.status, self.reason = status, reason

    def worsen(self, status: str, reason: str) -> None:
        """End with this status where the task itself came to an end; its own reason stays in front."""
        if self.status in ("SUCCESS", "FAILURE"):
            self.end(status, "; ".join(text for text in (self.reason, reason) if text))

    def worsen_by(self, errors: Sequence[BaseException]) -> None:
        """End as the worst of some errors says, where the task itself came to an end."""
        worst = next((e for e in errors if isinstance(e, DeviceFault)), errors[0] if errors else None)
        if worst is not None:
            self.worsen(status_of(worst), reason_of(worst))

    def finally_failed(self, reason: str, status: str = "FAILURE") -> None:
        """Keep why a `finally` failed, which a task that was done fails by."""
        self.errors.append(f"finally: {reason}")
        if self.status == "SUCCESS":
            self.end(status, f"the task was done, but its finally failed: {reason}")
        elif status != "FAILURE":
            self.worsen(status, f"its finally failed: {reason}")

    def blame(self, error: BaseException) -> None:
        """Keep where own code broke, if it did."""
        found = blame(error)
        if found is not None:
            self.broken.append(found)


def status_of(error: BaseException) -> str:
    """Return how a run ends that an error ended."""
    if isinstance(error, KeyboardInterrupt | CutOff):
        return "INTERRUPTED"
    return "FAULT" if isinstance(error, DeviceFault) else "ERROR"


def reason_of(error: BaseException) -> str:
    """Return what is said of an error."""
    return writable(error if isinstance(error, StretchError | CutOff) else named(error))
