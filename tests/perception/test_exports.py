import subprocess
import sys
from pathlib import Path

import stretch_bt.perception as perception


def test_every_exported_name_resolves_and_none_is_hidden_by_its_module():
    for name in perception.__all__:
        assert callable(getattr(perception, name)), name
    modules = {p.stem for p in Path(perception.__file__).parent.glob("*.py")}
    assert not modules & set(perception.__all__)
    assert perception.__all__ == sorted(perception._MODULES)


def test_an_unknown_name_is_an_attribute_error():
    assert not hasattr(perception, "no_such_name")


def test_importing_the_package_and_its_types_loads_nothing_heavy():
    code = "import sys, stretch_bt.perception.types; print(sorted({'cv2', 'scipy'} & set(sys.modules)))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert shown.stdout.strip() == "[]"
