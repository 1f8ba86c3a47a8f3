"""Promises about the repository itself."""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_importing_the_package_compiles_and_loads_nothing_heavy():
    code = "import sys, footscan.errors, footscan.coordinates; print('numba' in sys.modules, 'cv2' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout.split() == ["False", "False"]


def test_only_config_reads_toml_and_only_the_adapter_imports_numba():
    for path in (ROOT / "footscan").rglob("*.py"):
        text, place = path.read_text(), path.relative_to(ROOT / "footscan").as_posix()
        assert place.startswith("config/") or not re.search(r"^\s*(import|from) (tomllib|tomli_w)", text, re.M), place
        assert place == "compiled.py" or not re.search(r"^\s*(import|from) numba", text, re.M), place


def test_every_document_the_readme_names_exists():
    for target in re.findall(r"\]\(([^)h][^)]*)\)", (ROOT / "README.md").read_text()):
        assert (ROOT / target.partition("#")[0]).exists(), target
