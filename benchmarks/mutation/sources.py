"""Which files of the package belong to which domain of hard cases."""

from __future__ import annotations

import hashlib
from pathlib import Path

import stretch_bt

__all__ = ["DOMAINS", "PACKAGE", "code", "files", "module_of"]

PACKAGE = Path(stretch_bt.__file__).parent
#: patterns of files from the package on; one that begins with `!` takes files out again
DOMAINS: dict[str, tuple[str, ...]] = {
    "membrane": (
        "simulation/membrane/*.py",
        "simulation/membrane/materials/*.py",
        "simulation/membrane/sheet/*.py",
        "!simulation/membrane/picture.py",
        "!simulation/membrane/sheet/friction*.py",
        "!simulation/membrane/sheet/increments.py",
    ),
    "friction": (
        "simulation/membrane/sheet/friction*.py",
        "simulation/membrane/sheet/increments.py",
        "simulation/effects/friction.py",
    ),
    "indenters": ("simulation/membrane/indenters/*.py",),
    "balloons": ("simulation/balloons/*.py", "simulation/objects/balloon.py"),
    "dough": ("simulation/dough/*.py", "simulation/objects/dough.py"),
    "coupling": (
        "simulation/coupling.py",
        "simulation/solve.py",
        "simulation/objects/response.py",
        "simulation/objects/buckling.py",
        "simulation/objects/roof.py",
    ),
    "camera": (
        "simulation/camera/*.py",
        *(
            f"simulation/effects/{name}.py"
            for name in (
                "correlated_noise",
                "drift",
                "dropout",
                "fixed_pattern",
                "flying_pixels",
                "lens_distortion",
                "quantisation",
                "white_noise",
            )
        ),
    ),
    "perception": (
        "perception/*.py",
        "perception/[c-z]*/*.py",
        "!perception/io.py",
        "!perception/clouds/picture.py",
        "!perception/clouds/ply.py",
        "!perception/shapes/*.py",
    ),
    "fits": ("perception/shapes/*.py",),
    "model": ("model/*.py", "model/*/*.py", "!model/calibration/picture.py"),
}


def files(domain: str) -> list[Path]:
    """Return the files of a domain, sorted."""
    found: set[Path] = set()
    for pattern in DOMAINS[domain]:
        if pattern.startswith("!"):
            found -= set(PACKAGE.glob(pattern[1:]))
        else:
            found |= set(PACKAGE.glob(pattern))
    return sorted(path for path in found if path.name != "__init__.py")


def module_of(path: Path) -> str:
    """Return the name under which a file of the package is imported."""
    return ".".join(("stretch_bt", *path.relative_to(PACKAGE).with_suffix("").parts))


def code(*domains: str) -> str:
    """Return a digest of the package with the hard cases of some domains."""
    cases = PACKAGE / "hardcases" / "domains"
    of = [path for domain in domains for path in (cases / f"{domain}.py", cases / domain)]
    digest = hashlib.sha256()
    for path in sorted(path for path in PACKAGE.rglob("*") if path.is_file() and path.suffix != ".pyc"):
        if cases not in path.parents or any(path == one or one in path.parents for one in of):
            digest.update(f"{path.relative_to(PACKAGE)}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:16]
