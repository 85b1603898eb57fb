"""The paper's trends from the material's parameters alone, each figure beside what the paper says.

    python -m benchmarks.membrane_trends [stretch] [diameter] [mount] [shapes] [flat]

E* is the least-squares fit through 0 of the force, in steps of 1 mm of depth, to the Hertz formula that the paper prints
for the shape. Without weight the force is proportional to the shear modulus, and of stretch and mount pre-stretch only
the sum counts: how far the clamps are pulled past the unstressed length. Times are CPU time of one thread.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, curve_fit

from stretch_bt.model.hertz import hertz_force
from stretch_bt.simulation.membrane.press import SHEAR_MODULUS, press
from stretch_bt.simulation.membrane.sheet.result import SheetPress
from stretch_bt.simulation.membrane.sheet.settings import Settings

Array = npt.NDArray[np.float64]

GAUGES = (0.100, 0.075)
FIT_DEPTHS = (5, 10, 15)  # mm
PULLS = np.linspace(0.003, 0.103, 21)
STRETCHES = np.linspace(0.0, 0.060, 7)
DIAMETERS = np.linspace(0.010, 0.030, 5)
SOFTEST, STIFFEST = 4e3, 9e3  # Pa, at a stretch of 0 and of 60 mm: about, says the paper
EXACT = Settings()
ERROR = 0.003  # of E*, one standard deviation: what the sheet states for its forces, nearly the same at all depths


class Mount(NamedTuple):
    """The shear modulus, Pa, and the mount pre-stretch, m, at which E* spans 4 to 9 kPa.

    The standard deviations follow from the solver's own error.
    """

    shear_modulus: float
    prestretch: float
    shear_modulus_sd: float
    prestretch_sd: float
    prestretch_per_tenth: float  # how far it moves when the ratio of 9 to 4 kPa is a tenth less or more


@cache
def forces(indenter: str, gauge: float, pull: float, settings: Settings = EXACT) -> Array:
    """Return the forces (15,), N, of presses of 1 to 15 mm at the default shear modulus, each started from the last."""
    found, state = np.empty(15), None
    for k in range(15):
        state = press(indenter, pull, (k + 1) * 1e-3, gauge=gauge, settings=settings, start=state)
        found[k] = state.force
    return found


def hertz(indenter: str, depths: Array) -> Array:
    """Return the forces, N, of the paper's formula at E* = 1 Pa."""
    shape, _, size = indenter.partition(":")
    if shape == "cone":
        return np.asarray(hertz_force(shape, depths, 1.0, angle=math.radians(float(size.removesuffix("deg")))))
    return np.asarray(hertz_force(shape, depths, 1.0, radius=float(size.removesuffix("mm")) / 2e3))


def fit(indenter: str, depths: Array, measured: Array) -> tuple[float, float]:
    """Return E*, Pa, and the R2 of its fit."""
    form = hertz(indenter, depths)
    modulus = float(form @ measured / (form @ form))
    return modulus, r2(measured, modulus * form)


def effective_modulus(
    indenter: str, gauge: float, pull: float, fit_depth: int = 10, settings: Settings = EXACT
) -> tuple[float, float]:
    """Return E*, Pa, at the default shear modulus over depths of 1 to `fit_depth` mm, and the R2 of its fit.

    `pull` is how far the clamps are apart past the gauge, m: mount pre-stretch plus stretch.
    """
    depths = 1e-3 * np.arange(1.0, fit_depth + 1)
    return fit(indenter, depths, forces(indenter, gauge, pull, settings)[:fit_depth])


def r2(values: Array, fitted: Array) -> float:
    """Return the share of the variance that a fit explains."""
    return 1 - float(np.sum((values - fitted) ** 2) / np.sum((values - values.mean()) ** 2))


def linear_r2(x: Array, values: Array) -> float:
    """Return the R2 of the straight line a + b x."""
    return r2(values, np.asarray(np.polyval(np.polyfit(x, values, 1), x), dtype=float))


def curve_r2(law: Callable[..., Array], x: Array, values: Array, guess: tuple[float, ...]) -> tuple[float, Array]:
    """Return the R2 of a curve, fitted to the values themselves, and its parameters."""
    parameters, _ = curve_fit(law, x, values, p0=guess, maxfev=20000)
    return r2(values, law(x, *parameters)), np.asarray(parameters)


def shifted_log_r2(stretch: Array, values: Array) -> tuple[float, float]:
    """Return the R2 of a + b ln(x + c), and c, m."""
    quality, (_, _, offset) = curve_r2(
        lambda x, a, b, c: a + b * np.log(x + abs(c)), stretch, values, (10 * values.mean(), values.mean(), 0.02)
    )
    return quality, abs(float(offset))


@cache
def modulus_law(indenter: str, gauge: float, fit_depth: int) -> CubicSpline:
    """Return ln E* by how far the clamps are apart past the gauge, m: smooth, so a spline through 21 paths gives it."""
    moduli = [effective_modulus(indenter, gauge, float(pull), fit_depth)[0] for pull in PULLS]
    return CubicSpline(PULLS, np.log(moduli))


def find_mount(indenter: str, gauge: float, fit_depth: int) -> Mount:
    """Return the mount at which E* is 4 kPa at a stretch of 0 and 9 kPa at 60 mm.

    The ratio of the two gives the pre-stretch, whatever the shear modulus; the shear modulus follows by proportion.
    """
    law = modulus_law(indenter, gauge, fit_depth)
    wanted = math.log(STIFFEST / SOFTEST)
    prestretch = float(brentq(lambda x: float(law(x + 0.06) - law(x)) - wanted, PULLS[0], 0.04))
    soft, stiff = float(law(prestretch, 1)), float(law(prestretch + 0.06, 1))
    slope = stiff - soft  # of the logarithm of the ratio
    # the errors of E* at the two ends, taken as independent, move the pre-stretch and with it the shear modulus
    shear_modulus = SHEAR_MODULUS * SOFTEST / math.exp(float(law(prestretch)))
    shear_sd = shear_modulus * ERROR * math.hypot(stiff / slope, soft / slope)
    return Mount(shear_modulus, prestretch, shear_sd, math.sqrt(2) * ERROR / abs(slope), 0.1 / abs(slope))


def by_stretch() -> None:
    print("E*, kPa, of a sphere of 20 mm by stretch 0, 10 .. 60 mm, fitted over 1 to 10 mm")
    print("  the paper: about 4 to 9, rising with every stretch, a logarithm of the stretch fitted to it")
    for gauge in GAUGES:
        found = find_mount("sphere:20mm", gauge, 10)
        for mount in (0.0, found.prestretch):
            scale = found.shear_modulus / SHEAR_MODULUS if mount else 1.0
            pairs = [effective_modulus("sphere:20mm", gauge, mount + float(x)) for x in STRETCHES]
            moduli = scale * np.array([e for e, _ in pairs]) / 1e3
            print(
                f"  gauge {gauge * 1e3:.0f} mm, mount pre-stretch {mount * 1e3:.1f} mm, shear modulus "
                f"{scale * SHEAR_MODULUS / 1e3:.1f} kPa: " + " ".join(f"{e:.2f}" for e in moduli)
            )
            print("    R2 of the Hertz fits: " + " ".join(f"{q:.4f}" for _, q in pairs))
            x, taut = STRETCHES[1:], moduli[1:]
            line, log = linear_r2(x, taut), linear_r2(np.log(x), taut)
            print(f"    R2 over 10 to 60 mm: a + b ln x {log:.4f}, line {line:.4f}")
            if mount:
                known, free = linear_r2(np.log(STRETCHES + mount), moduli), shifted_log_r2(STRETCHES, moduli)
                print(
                    f"    R2 over 0 to 60 mm: a + b ln(x + mount pre-stretch) {known:.4f}, a + b ln(x + c) {free[0]:.4f}"
                    f" with c = {free[1] * 1e3:.1f} mm, line {linear_r2(STRETCHES, moduli):.4f}"
                )


def by_diameter() -> None:
    print(
        "E*, kPa, by diameter 10, 15 .. 30 mm of a sphere, fitted over 1 to 10 mm, with the mount that spans 4 to 9 kPa"
    )
    print("  the paper: falls with diameter at every stretch, a negative exponential fitted to it")
    for gauge in GAUGES:
        mount = find_mount("sphere:20mm", gauge, 10)
        for stretch in (0.0, 0.03, 0.06):
            moduli = np.array(
                [effective_modulus(f"sphere:{d * 1e3:g}mm", gauge, mount.prestretch + stretch)[0] for d in DIAMETERS]
            ) * (mount.shear_modulus / SHEAR_MODULUS / 1e3)
            power, (_, exponent) = curve_r2(lambda d, a, n: a * d**n, DIAMETERS / 0.02, moduli, (5.0, -0.3))
            fading, _ = curve_r2(lambda d, a, b: a * np.exp(-b * d), DIAMETERS / 0.02, moduli, (8.0, 0.3))
            level, _ = curve_r2(lambda d, a, b, c: c + a * np.exp(-b * d), DIAMETERS / 0.02, moduli, (4.0, 1.0, 4.0))
            print(
                f"  gauge {gauge * 1e3:.0f} mm, stretch {stretch * 1e3:.0f} mm: "
                + " ".join(f"{e:.2f}" for e in moduli)
                + f"; power law D^{exponent:.3f} R2 {power:.4f}, a exp(-b D) {fading:.4f}, "
                + f"c + a exp(-b D) {level:.4f}"
            )


def mounts() -> None:
    print("what spans 4 kPa at stretch 0 and 9 kPa at 60 mm, sphere of 20 mm (the paper states neither)")
    for gauge in GAUGES:
        for depth in FIT_DEPTHS:
            found = find_mount("sphere:20mm", gauge, depth)
            soft, stiff = (effective_modulus("sphere:20mm", gauge, found.prestretch + x, depth) for x in (0.0, 0.06))
            scale = found.shear_modulus / SHEAR_MODULUS / 1e3
            rise = scale * soft[0] * float(modulus_law("sphere:20mm", gauge, depth)(found.prestretch, 1)) * 1e-3
            print(
                f"  gauge {gauge * 1e3:.0f} mm, fit over 1 to {depth} mm: shear modulus {found.shear_modulus / 1e3:.1f} "
                f"+- {found.shear_modulus_sd / 1e3:.1f} kPa, mount pre-stretch {found.prestretch * 1e3:.2f} "
                f"+- {found.prestretch_sd * 1e3:.2f} mm; E* {scale * soft[0]:.3f} and {scale * stiff[0]:.3f} kPa, R2 "
                f"{soft[1]:.4f} and {stiff[1]:.4f}; a tenth in the ratio 9/4 is "
                f"{found.prestretch_per_tenth * 1e3:.1f} mm, dE*/d(pre-stretch) {rise:.2f} kPa/mm"
            )


def shapes() -> None:
    print("E*, kPa, by stretch 0, 10 .. 60 mm of the other shapes, with the mount of the sphere for the same fit depth")
    for gauge in GAUGES:
        for depth in FIT_DEPTHS:
            mount = find_mount("sphere:20mm", gauge, depth)
            for indenter in ("cylinder:20mm", "cone:45deg"):
                pairs = [effective_modulus(indenter, gauge, mount.prestretch + float(x), depth) for x in STRETCHES]
                scale = mount.shear_modulus / SHEAR_MODULUS / 1e3
                print(
                    f"  gauge {gauge * 1e3:.0f} mm, fit over 1 to {depth} mm, {indenter}: "
                    + " ".join(f"{scale * e:.2f}" for e, _ in pairs)
                    + f"; R2 {min(q for _, q in pairs):.3f} to {max(q for _, q in pairs):.3f}"
                )
            own = find_mount("cylinder:20mm", gauge, depth)
            print(
                f"    a cylinder of 20 mm spans 4 to 9 kPa at {own.shear_modulus / 1e3:.1f} +- "
                f"{own.shear_modulus_sd / 1e3:.1f} kPa and {own.prestretch * 1e3:.2f} +- {own.prestretch_sd * 1e3:.2f} mm"
            )


def flat_mount() -> None:
    print(f"flat, untensioned mount at stretch 0, sphere of 20 mm, shear modulus {SHEAR_MODULUS / 1e3:.1f} kPa")
    for gauge in GAUGES:
        found = forces("sphere:20mm", gauge, 0.0)
        for depth in FIT_DEPTHS:
            modulus, quality = effective_modulus("sphere:20mm", gauge, 0.0, depth)
            z = np.arange(3.0, depth + 1)
            power = np.polyfit(np.log(z), np.log(found[2:depth]), 1)[0]
            print(
                f"  gauge {gauge * 1e3:.0f} mm, fit over 1 to {depth} mm: E* {modulus / 1e3:.3f} kPa, R2 {quality:.3f}, "
                f"F ~ depth^{power:.2f} over 3 to {depth} mm, F {found[depth - 1] * 1e3:.1f} mN"
            )
        hanging(gauge)


def hanging(gauge: float) -> None:
    """Print the same with weight: the sheet hangs towards the indenter, which lifts it."""
    # a touch beside the clamp leaves the rest of the sheet as it hangs
    touch = press("sphere:1mm", 0.0, 1e-5, at=(0.0, gauge / 2 - 0.5e-3), gauge=gauge, effects=["sag"]).detail
    assert isinstance(touch, SheetPress)
    sag = -float(touch.shape.height(np.zeros(1), np.zeros(1))[0])
    depths, found, state = np.linspace(0.001, 0.015, 15), np.empty(15), None
    for k, depth in enumerate(depths):
        state = press("sphere:20mm", 0.0, float(depth), gauge=gauge, effects=["sag"], start=state)
        found[k] = state.force
    past = depths + sag
    for label, z in (("the flat plane", depths), ("first touch", past)):
        inside = z <= 0.0151
        modulus, quality = fit("sphere:20mm", z[inside], found[inside])
        power = np.polyfit(np.log(z[inside]), np.log(found[inside]), 1)[0]
        print(
            f"    hanging {sag * 1e3:.2f} mm, depth from {label}, {z[inside][0] * 1e3:.1f} to {z[inside][-1] * 1e3:.1f} mm: "
            f"E* {modulus / 1e3:.3f} kPa, R2 {quality:.3f}, F ~ depth^{power:.2f}"
        )
    print(
        f"    F from the flat plane at 1, 5, 10, 15 mm: {', '.join(f'{found[k] * 1e3:.1f}' for k in (0, 4, 9, 14))} mN"
    )


PARTS: dict[str, Callable[[], None]] = {
    "stretch": by_stretch,
    "diameter": by_diameter,
    "mount": mounts,
    "shapes": shapes,
    "flat": flat_mount,
}


def main() -> None:
    """Run the parts that are named, or all."""
    for name in sys.argv[1:] or PARTS:
        began = time.process_time()
        PARTS[name]()
        print(f"  {time.process_time() - began:.1f} s of CPU")


if __name__ == "__main__":
    main()
