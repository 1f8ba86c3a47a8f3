"""A file that is no whole mesh is refused by what is wrong with it."""

from pathlib import Path

import pytest
import trimesh

from footscan.errors import MeshError
from footscan.foot.mesh_file import load_foot_mesh

BINARY = trimesh.creation.icosphere(2).export(file_type="stl")
TEXT = trimesh.creation.icosphere(2).export(file_type="stl_ascii").encode()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("empty.stl", b"", "empty"),
        ("empty.ply", b"", "empty"),
        ("half.stl", BINARY[: len(BINARY) // 2], "counts 320 triangles, it holds 15"),
        ("head.stl", BINARY[:60], "60 bytes"),
        ("half_text.stl", TEXT[: len(TEXT) // 2], "endsolid"),
        ("letter.stl", b"this is a letter to the last maker, no mesh at all.\n" * 3, "is text, but no STL"),
        ("letter.obj", b"this is a letter\n", "no triangles"),
        ("none.stl", bytes(84), "no triangles"),
        ("half.ply", trimesh.creation.icosphere(2).export(file_type="ply")[:900], "cut off"),
    ],
)
def test_what_is_no_whole_mesh_is_refused(tmp_path: Path, name: str, content: bytes, words: str):
    (tmp_path / name).write_bytes(content)

    with pytest.raises(MeshError, match=words):
        load_foot_mesh(tmp_path / name)


@pytest.mark.parametrize("content", [BINARY, b"solid" + BINARY[5:], TEXT], ids=["binary", "binary named solid", "text"])
def test_whole_files_are_read(tmp_path: Path, content: bytes):
    (tmp_path / "ball.stl").write_bytes(content)

    assert len(load_foot_mesh(tmp_path / "ball.stl").faces) == 320
