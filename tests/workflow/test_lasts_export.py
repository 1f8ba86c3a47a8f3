"""Every kind of file holds the same last; what a file cannot hold is refused before anything is written."""

from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import trimesh

from footscan.errors import FootscanError, InputError, MeshError
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.handed import mirrored
from footscan.shoelast.model import Shoelast
from footscan.shoelast.nurbs_out import load_last_json
from footscan.shoelast.rhino_read import read_3dm
from footscan.workflow.lasts_export import KINDS, ExportWish, export_last, load_custom


@pytest.fixture(scope="module")
def shoelast() -> Shoelast:
    return build_shoelast("women", 37, "g", 30.0, "almond", "left", stub=True)


def _extent(shoelast: Shoelast) -> np.ndarray:
    xyz = mirrored(shoelast.upper.grid(np.arange(1440) / 1440, np.linspace(0, 1, 201)), shoelast.side).reshape(-1, 3)
    low = shoelast.bottom.grid(np.linspace(0, 1, 401), np.linspace(0, 1, 41))[..., 2].min()
    return np.array([[*xyz.min(axis=0)[:2], low], xyz.max(axis=0)])


def _read(path: Path) -> np.ndarray:
    """The box of what a file holds, read by a program that is not ours where there is one."""
    kind = path.suffix
    if kind in {".stl", ".obj", ".ply"}:
        return trimesh.load(path, force="mesh").bounds
    if kind == ".3dm":
        return read_3dm(path).mesh.bounds
    if kind == ".dxf":
        sections = [e for e in ezdxf.readfile(path).modelspace().query("POLYLINE") if "SECTION" in e.dxf.layer]
        corners = np.array([v.dxf.location for e in sections for v in e.vertices])
        return np.array([corners.min(axis=0), corners.max(axis=0)])
    from footscan.shoelast.cad_file import read_cad

    return read_cad(path, 0.2).mesh.bounds


@pytest.mark.parametrize("kind", ["stl", "obj", "ply", "3dm", "step", "igs"])
def test_a_built_in_last_leaves_and_comes_back_in_its_place(shoelast: Shoelast, kind: str, tmp_path: Path):
    if kind in {"step", "igs"}:
        pytest.importorskip("OCP.STEPControl", reason="the extra cad (OCP) is not installed")

    done = export_last(shoelast, tmp_path / f"last.{kind}")

    assert done.files == (tmp_path / f"last.{kind}",)
    assert np.abs(_read(done.files[0]) - _extent(shoelast)).max() < (0.2 if kind in {"step", "igs"} else 0.03)
    assert [path.name for path in tmp_path.iterdir()] == [f"last.{kind}"]


def test_the_sections_of_the_drawing_reach_as_wide_and_high_as_the_last(shoelast: Shoelast, tmp_path: Path):
    found = _read(export_last(shoelast, tmp_path / "last.dxf").files[0])

    assert np.abs(found[:, 2] - _extent(shoelast)[:, 2]).max() < 3.0, "sections lie every 20 mm"


def test_a_folder_of_customise_is_read(shoelast: Shoelast, tmp_path: Path):
    export_last(shoelast, tmp_path / "custom.json")

    back = load_custom(tmp_path)

    assert np.abs(back.upper.net_mm - shoelast.upper.net_mm).max() < 1e-9
    assert load_last_json(tmp_path / "custom.json").attachments[0].kind == "stub"


def test_stub_and_engraving_and_sheet_come_together(shoelast: Shoelast, tmp_path: Path):
    wish = ExportWish(stub=True, engrave="A17 L 37", sheet="a4", order="A17")

    done = export_last(shoelast, tmp_path / "last.stl", wish)

    mesh = trimesh.load(done.files[0], force="mesh")
    plain = trimesh.load(export_last(shoelast, tmp_path / "plain.stl").files[0], force="mesh")
    assert [path.name for path in done.files] == ["last.stl", "last.pdf"]
    assert mesh.is_watertight
    assert mesh.bounds[0, 0] < plain.bounds[0, 0] - 10.0, "the stub stands behind the heel"
    assert any("engraved 'A17 L 37'" in words for words in done.found)
    assert any("3 pages" in words for words in done.found)


@pytest.mark.parametrize("kind", ["step", "igs", "dxf", "json", "pdf"])
def test_what_a_file_cannot_hold_is_refused_and_nothing_written(shoelast: Shoelast, kind: str, tmp_path: Path):
    for wish, said in ((ExportWish(engrave="A17"), "engrave"), (ExportWish(stub=True), "stub")):
        with pytest.raises(InputError, match=said):
            export_last(shoelast, tmp_path / f"last.{kind}", wish)

    assert not list(tmp_path.iterdir())


def test_an_unknown_kind_names_the_known_ones(shoelast: Shoelast, tmp_path: Path):
    for name in ("last.docx", "last"):
        with pytest.raises(FootscanError, match="allowed are stl, obj") as refusal:
            export_last(shoelast, tmp_path / name)
        assert all(kind[1:] in str(refusal.value) for kind in KINDS)


def test_no_stub_cannot_be_given_back(shoelast: Shoelast, tmp_path: Path):
    bare = replace(shoelast, attachments=())

    for kind in ("stl", "3dm"):
        with pytest.raises(MeshError, match="no stub"):
            export_last(bare, tmp_path / f"last.{kind}", ExportWish(stub=True))
