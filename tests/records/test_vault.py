import os
import shutil
from pathlib import Path

import pytest

from footscan.errors import InputError, StorageError
from footscan.records.tree_hash import hash_of_folder
from footscan.records.vault import Vault


@pytest.fixture
def source(tmp_path):
    folder = tmp_path / "source"
    (folder / "frames").mkdir(parents=True)
    (folder / "a.toml").write_text("a")
    (folder / "frames/0.png").write_bytes(b"0")
    return folder


@pytest.fixture
def vault(tmp_path):
    (tmp_path / "data").mkdir()
    return Vault(tmp_path / "data")


def put(vault, source, *, link=False):
    with vault.staged(source, link=link) as staged:
        assert vault.put(staged) is True
    return staged.sha256


def test_every_file_and_folder_is_synced_before_the_name_is_given_and_the_name_after(vault, source, monkeypatch):
    done = []
    fsync, rename = os.fsync, Path.rename
    monkeypatch.setattr(
        os, "fsync", lambda fd: (done.append(str(Path(f"/proc/self/fd/{fd}").readlink())), fsync(fd))[1]
    )
    monkeypatch.setattr(Path, "rename", lambda path, to: (done.append(f"rename {to.name}"), rename(path, to))[1])
    sha256 = put(vault, source)
    at = done.index(f"rename {sha256}")
    before = {Path(name).name for name in done[:at]}

    assert before == {"a.toml", "0.png", "frames", "content"}
    assert done[at + 1 :] == [str(vault.path(sha256).parent), *(str(vault.path(sha256).parents[k]) for k in (1, 2))]


@pytest.mark.parametrize("link", [True, False])
def test_a_kept_folder_has_the_content_of_its_source_and_cannot_be_written_by_chance(vault, source, link):
    kept = vault.path(put(vault, source, link=link))

    assert kept.name == hash_of_folder(source) == hash_of_folder(kept)
    assert all(path.stat().st_mode & 0o777 == 0o400 for path in kept.rglob("*") if path.is_file())
    assert (kept / "a.toml").samefile(source / "a.toml") == link


def test_a_disk_without_hard_links_gets_copies(vault, source, monkeypatch):
    def refuse(*_):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", refuse)

    assert not (vault.path(put(vault, source, link=True)) / "a.toml").samefile(source / "a.toml")


def test_the_same_content_is_kept_once(vault, source):
    sha256 = put(vault, source)
    with vault.staged(source, link=False) as staged:
        assert staged.sha256 == sha256
        assert vault.put(staged) is False

    assert vault.names() == [sha256]
    assert vault.dead_stages() == []


@pytest.mark.parametrize(
    "change",
    [
        lambda folder: (folder / "a.toml").write_text("b"),
        lambda folder: (folder / "a.toml").rename(folder / "b.toml"),
        lambda folder: (folder / "frames/0.png").unlink(),
        lambda folder: (folder / "frames/0.png").rename(folder / "0.png"),
        lambda folder: (folder / "more").touch(),
    ],
)
def test_every_change_changes_the_hash(source, change):
    before = hash_of_folder(source)
    change(source)

    assert hash_of_folder(source) != before


def test_a_stage_in_use_is_no_leftover_and_a_dead_one_is(vault, source, tmp_path):
    with vault.staged(source, link=False):
        assert vault.dead_stages() == []
    (tmp_path / "data/stage/stage-dead").mkdir()

    assert [path.name for path in vault.dead_stages()] == ["stage-dead"]


def test_an_ordered_removal_is_finished_later_and_nothing_else_is_touched(vault, tmp_path):
    stage = tmp_path / "data/stage"
    for name in ("discard-1", "stage-1"):
        (stage / name / "content").mkdir(parents=True)
    vault.finish_discards()

    assert [path.name for path in stage.iterdir()] == ["stage-1"]


def test_a_full_disk_while_copying_leaves_nothing(vault, source, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(shutil, "copyfile", full)
    with pytest.raises(StorageError, match="No space left"), vault.staged(source, link=False):
        pass

    assert vault.dead_stages() == vault.names() == []


def test_an_empty_or_missing_source_is_refused(vault, tmp_path):
    (tmp_path / "empty").mkdir()
    for place in (tmp_path / "empty", tmp_path / "nowhere"):
        with pytest.raises(InputError), vault.staged(place, link=False):
            pass
