"""Fail when the wheel lacks a file of the package, or has one too many."""

import subprocess
import sys
import zipfile

tracked = subprocess.run(["git", "ls-files", "stretch_bt"], capture_output=True, text=True, check=True).stdout.split()
packed = [name for name in zipfile.ZipFile(sys.argv[1]).namelist() if name.startswith("stretch_bt/")]
missing, extra = sorted(set(tracked) - set(packed)), sorted(set(packed) - set(tracked))
if missing or extra:
    sys.exit(f"the wheel lacks {missing} and has {extra} too many")
print(f"the wheel holds all {len(packed)} files")
