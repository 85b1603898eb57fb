"""MuJoCo's flex: a membrane of St. Venant-Kirchhoff triangles in time steps, with soft contact.

Its law stiffens with stretch where rubber does not, which is nearly all of its error; a finer grid does not help.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from stretch_bt.accuracy.peers import DENSITY, DEPTH, DIAMETER, SHEAR_MODULUS, STRETCH, PeerAnswer
from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.press import GAUGE, THICKNESS, WIDTH

__all__ = ["NAME", "PACKAGES", "SETTING", "press"]

NAME, PACKAGES = "MuJoCo flex", ("mujoco",)
_NODES, _TIME_STEP, _RAMP, _MOST_STEPS = 25, 1e-3, 50, 2000
SETTING = f"{_NODES} x {_NODES}, {_TIME_STEP * 1e3:g} ms"
_DAMPING = 250.0  # 1/s, about critical for the slowest wave across the sheet
_REST = 1e-4  # m/s, below which the sheet is at rest
_SCENE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="discrete"/>
  <worldbody>
    <body mocap="true" pos="0 0 {below}">
      <geom type="sphere" size="{radius}" condim="1" priority="1" solref="0.002 1" solimp="0.99 0.999 0.0001"/>
    </body>
    <flexcomp name="sheet" type="grid" dim="2" count="{n} {n} 1" spacing="{dx} {dy} 1" mass="{mass}" radius="1e-5">
      <elasticity young="{young}" poisson="0.49" thickness="{thickness}" elastic2d="stretch"/>
      <contact selfcollide="none" condim="1"/>
      <pin gridrange="0 0 {last} 0"/>
      <pin gridrange="0 {last} {last} {last}"/>
    </flexcomp>
  </worldbody>
</mujoco>
"""


def press() -> PeerAnswer:
    """Return the force once the sheet is at rest.

    Raises
    ------
    NoEquilibrium
        It does not come to rest.
    """
    import mujoco

    model, data = _stretched()
    began = time.process_time()
    for step in range(1, _MOST_STEPS + 1):
        data.mocap_pos[0, 2] = min(step / _RAMP, 1.0) * DEPTH - DIAMETER / 2
        mujoco.mj_step(model, data)
        if step > _RAMP and np.abs(data.qvel).max() < _REST:
            break
    else:
        raise NoEquilibrium(f"the sheet still moves after {_MOST_STEPS} steps")
    seconds = time.process_time() - began
    return PeerAnswer(_force(model, data), seconds)


def _stretched() -> tuple[Any, Any]:
    """Return model and state of the sheet, evenly stretched, over the sphere."""
    import mujoco

    mujoco.set_mju_user_warning(lambda text: None)  # else warnings go to a file in the working folder
    mass = DENSITY * WIDTH * GAUGE * THICKNESS
    scene = _SCENE.format(
        step=_TIME_STEP,
        below=-DIAMETER / 2,
        radius=DIAMETER / 2,
        n=_NODES,
        last=_NODES - 1,
        dx=WIDTH / (_NODES - 1),
        dy=GAUGE / (_NODES - 1),
        mass=mass,
        young=3 * SHEAR_MODULUS,
        thickness=THICKNESS,
    )
    model = mujoco.MjModel.from_xml_string(scene)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rest = data.flexvert_xpos.copy()
    pinned = model.flex_vertbodyid == 0
    model.flex_vert[pinned, 1] *= 1 + STRETCH / GAUGE
    for node in np.flatnonzero(~pinned):  # each has a slide along x, y and z
        first = model.jnt_qposadr[model.body_jntadr[model.flex_vertbodyid[node]]]
        data.qpos[first + 1] = rest[node, 1] * STRETCH / GAUGE
    model.dof_damping[:] = _DAMPING * mass / _NODES**2
    return model, data


def _force(model: Any, data: Any) -> float:
    """Return the contact force along z, N."""
    import mujoco

    total, wrench = 0.0, np.zeros(6)
    for k in range(data.ncon):
        mujoco.mj_contactForce(model, data, k, wrench)
        total += abs(wrench[0] * data.contact[k].frame[2])
    return float(total)
