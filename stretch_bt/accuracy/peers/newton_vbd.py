"""Newton's vertex block descent: a membrane of stable neo-Hookean triangles in time steps, with a contact penalty.

Its law is one of area alone and knows no thickness, which is most of its error.
"""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numpy as np

from stretch_bt.accuracy.peers import DENSITY, DEPTH, DIAMETER, SHEAR_MODULUS, STRETCH, PeerAnswer
from stretch_bt.errors import NoEquilibrium
from stretch_bt.simulation.membrane.press import GAUGE, THICKNESS, WIDTH

__all__ = ["NAME", "PACKAGES", "SETTING", "press"]

NAME, PACKAGES = "Newton VBD", ("newton", "warp")
_CELLS, _TIME_STEP, _RAMP, _MOST_STEPS, _ITERATIONS = 24, 5e-3, 20, 400, 20
SETTING = f"{_CELLS + 1} x {_CELLS + 1}, {_TIME_STEP * 1e3:g} ms, {_ITERATIONS} iterations"
_REST = 2e-3  # m/s; it goes on creeping for hundreds of steps
_PENALTY = 3000.0  # N/m of each node; a tenth of it lowers the force by 6 %, ten times it adds 1 %
_NODE_RADIUS = 1e-4


class _World(NamedTuple):
    solver: Any
    pipeline: Any
    contacts: Any
    wrenches: Any
    control: Any
    states: tuple[Any, Any]


def press() -> PeerAnswer:
    """Return the force once the sheet is at rest.

    Raises
    ------
    NoEquilibrium
        It does not come to rest.
    """
    import warp

    with warp.ScopedDevice("cpu"):
        _advance(_world(), 1)  # compiles
        world = _world()
        began = time.process_time()
        force = _settle(world)
        seconds = time.process_time() - began
    return PeerAnswer(force, seconds)


def _settle(world: _World) -> float:
    for step in range(1, _MOST_STEPS + 1):
        speed = _advance(world, step)
        if step > _RAMP and speed < _REST:
            return float(np.abs(world.wrenches.contact_f.numpy()[:, 2].sum()))
        world = world._replace(states=world.states[::-1])
    raise NoEquilibrium(f"the sheet still moves after {_MOST_STEPS} steps")


def _advance(world: _World, step: int) -> float:
    """Advance by one time step, and return the largest speed, m/s."""
    before, after = world.states
    place = before.body_q.numpy()
    place[0, 2] = min(step / _RAMP, 1.0) * DEPTH - DIAMETER / 2
    before.body_q.assign(place)
    before.clear_forces()
    world.pipeline.collide(before, world.contacts)
    world.solver.step(before, after, world.control, world.contacts, _TIME_STEP, observables=world.wrenches)
    return float(np.abs(after.particle_qd.numpy()).max())


def _world() -> _World:
    """Return the sheet, evenly stretched, over the sphere."""
    import newton

    model = _model()
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = _PENALTY, 0.0, 0.0
    solver = newton.solvers.SolverVBD(model, iterations=_ITERATIONS)
    pipeline = newton.CollisionPipeline(model)
    contacts = pipeline.contacts()
    states = (model.state(), model.state())
    nodes = states[0].particle_q.numpy()
    nodes[:, 1] *= 1 + STRETCH / GAUGE
    for state in states:
        state.particle_q.assign(nodes)
    wrenches = solver.observables(["contact_f"], contacts=contacts)
    return _World(solver, pipeline, contacts, wrenches, model.control(), states)


def _model() -> Any:
    import newton
    import warp

    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    stiffness = SHEAR_MODULUS * THICKNESS
    builder.add_cloth_grid(
        pos=warp.vec3(-WIDTH / 2, -GAUGE / 2, 0.0),
        rot=warp.quat_identity(),
        vel=warp.vec3(0.0, 0.0, 0.0),
        dim_x=_CELLS,
        dim_y=_CELLS,
        cell_x=WIDTH / _CELLS,
        cell_y=GAUGE / _CELLS,
        mass=DENSITY * WIDTH * GAUGE * THICKNESS / (_CELLS + 1) ** 2,
        fix_top=True,
        fix_bottom=True,
        tri_ke=stiffness,
        tri_ka=2 * stiffness,  # plane stress of an incompressible solid, at small strain
        tri_kd=0.0,
        edge_ke=0.0,
        edge_kd=0.0,
        particle_radius=_NODE_RADIUS,
    )
    below = warp.transform(warp.vec3(0.0, 0.0, -DIAMETER / 2), warp.quat_identity())
    body = builder.add_body(xform=below, is_kinematic=True)
    surface = newton.ModelBuilder.ShapeConfig(density=0.0, ke=_PENALTY, kd=0.0, mu=0.0)
    builder.add_shape_sphere(body, radius=DIAMETER / 2 - _NODE_RADIUS, cfg=surface)
    builder.color()
    return builder.finalize()
