"""STEP and IGES hold the real last as a closed body, and come back; without the kernel they are refused by name."""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from footscan.coordinates import Side
from footscan.errors import InputError, MeshError
from footscan.shoelast.handed import mirrored
from footscan.shoelast.mesh_out import mesh_of_last
from footscan.shoelast.model import Shoelast

pytest.importorskip("OCP.STEPControl", reason="the extra cad (OCP) is not installed")
from footscan.shoelast.cad_file import read_cad, save_last_cad
from footscan.shoelast.cad_kernel import body_of, read_cad_file, solid_from_patches
from footscan.shoelast.nurbs_out import clamped_patches

Tub = Callable[[Side], Shoelast]


@pytest.mark.parametrize("kind", ["step", "igs"])
@pytest.mark.parametrize("side", ["right", "left"])
def test_a_file_read_back_is_the_closed_last(tub: Tub, side: Side, kind: str, tmp_path: Path):
    shoelast, path = tub(side), tmp_path / f"tub.{kind}"

    check = save_last_cad(shoelast, path, "tub")

    mesh = mesh_of_last(shoelast).bodies["last"]
    assert check.deviation_mm < 1e-6
    assert (check.faces, check.free_edges) == (3, 0)
    assert check.volume_mm3 == pytest.approx(mesh.volume, rel=3e-4)
    back = read_cad(path, 0.2).mesh
    assert np.allclose(back.bounds, mesh.bounds, atol=0.2)
    assert (back.bounds[1, 1] > -back.bounds[0, 1]) == (side == "right")


def test_the_step_body_is_one_valid_solid_and_its_mesh_is_closed(bare_tub: Shoelast, tmp_path: Path):
    save_last_cad(bare_tub, tmp_path / "tub.stp", "tub")

    body = body_of(read_cad_file(tmp_path / "tub.stp").shape, 1e-6)
    mesh = read_cad(tmp_path / "tub.stp", 0.2).mesh

    assert body.valid
    assert mesh.is_watertight
    assert mesh.volume > 0


def test_faces_bear_their_names_and_the_head_the_datum(bare_tub: Shoelast, tmp_path: Path):
    save_last_cad(bare_tub, tmp_path / "tub.step", "order 17")

    text = (tmp_path / "tub.step").read_text()
    assert all(f"ADVANCED_FACE('{name}'" in text for name in ("upper", "bottom", "cone_top"))
    assert "order 17" in text
    assert "rearmost point of the back" in text.replace("\n", "")


def test_nothing_is_printed_by_the_kernel(bare_tub: Shoelast, tmp_path: Path, capfd: pytest.CaptureFixture[str]):
    save_last_cad(bare_tub, tmp_path / "tub.step", "tub")
    save_last_cad(bare_tub, tmp_path / "tub.iges", "tub")
    read_cad(tmp_path / "tub.iges", 0.2)

    assert capfd.readouterr().out == ""


def test_patches_that_do_not_meet_are_no_body(bare_tub: Shoelast):
    upper, bottom, top = clamped_patches(bare_tub)
    away = replace(bottom, net_mm=bottom.net_mm - np.array([0.0, 0.0, 0.5]))

    with pytest.raises(MeshError, match="open edges"):
        solid_from_patches((upper, away, top))


def test_what_is_no_step_file_is_refused(tmp_path: Path):
    (tmp_path / "text.step").write_text("nothing of the kind")

    for name in ("text.step", "missing.iges"):
        with pytest.raises(MeshError, match="cannot be read as"):
            read_cad(tmp_path / name)


def test_without_the_extra_the_message_says_how_to_install_it(
    bare_tub: Shoelast, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    for name in [name for name in sys.modules if name == "OCP" or name.startswith("OCP.")]:
        monkeypatch.setitem(sys.modules, name, None)

    with pytest.raises(InputError, match=r'pip install "footscan\[cad\]"'):
        save_last_cad(bare_tub, tmp_path / "tub.step", "tub")
    assert not list(tmp_path.iterdir())


def test_the_left_solid_is_the_mirrored_right_one(tub: Tub):
    right, left = clamped_patches(tub("right")), clamped_patches(tub("left"))
    share = np.linspace(0.0, 1.0, 9)

    assert np.allclose(mirrored(right[0].grid(1.0 - share, share), "left"), left[0].grid(share, share))
