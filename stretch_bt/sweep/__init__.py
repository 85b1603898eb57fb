"""Many runs: each scene, seed and combination of params of a sweep file, here or on other machines, one row for each.

An item goes through these modules in this order: `items` makes its `Spec` from the sweep file, an engine hands that to
`run_item` in some process, and `rows` writes what comes back.
"""

from stretch_bt.sweep.job import Ran
from stretch_bt.sweep.run_item import run_item
from stretch_bt.sweep.spec import Spec
from stretch_bt.sweep.sweeping import Swept, sweep

__all__ = ["Ran", "Spec", "Swept", "run_item", "sweep"]
