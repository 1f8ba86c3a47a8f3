"""How long ranking, comparing, customising and importing lasts take."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import trimesh

from footscan.coordinates import Floats
from footscan.geometry.mesh_distance import DistanceMesh
from footscan.shoelast.compare import compare
from footscan.shoelast.customise import CustomSettings, customise
from footscan.shoelast.family import build_shoelast
from footscan.shoelast.import_last import shoelast_from_mesh
from footscan.shoelast.last_library import LastEntry, family_entries
from footscan.shoelast.model import Shoelast
from footscan.shoelast.prepared_foot import PreparedFoot, prepare_foot
from footscan.shoelast.rank import rank
from footscan.shoelast.skin import Sampling, skin_of
from footscan.shoelast.source import LastSource
from footscan.shoelast.stub import chuck_stub
from footscan.sim.foot import FootShape, build_foot
from footscan.sim.surface import trimesh_from_surface

RANKED = 1000
IMPORTED = Sampling(400, 150, 40)


@dataclass(frozen=True)
class LastTiming:
    """Seconds of one step: minimum, median, and processor seconds (minimum); a baseline where there is one."""

    step: str
    wall_s: tuple[float, float]
    cpu_s: float
    target_s: float | None
    baseline: str = ""
    baseline_s: float | None = None


def time_lasts(repeats: int) -> list[LastTiming]:
    """Time every step on the built-in foot and its best built-in last."""
    foot = prepare_foot(trimesh_from_surface(build_foot(FootShape("right", 1.0))), "right")
    entries = _many(list(family_entries()), RANKED)
    therapeutic = [entry for entry in family_entries() if entry.style == "therapeutic"]
    best = rank(therapeutic, foot)[0].entry
    toe = best.id.split("-")[4]
    pitch = best.pitch_mm or 15.0
    shoelast = build_shoelast("therapeutic", best.size_eu or 42.0, best.fitting, pitch, toe, "right")
    fast, slow = CustomSettings(transition_mm=10.0), CustomSettings(transition_mm=20.0)
    return [
        _timed(f"rank {RANKED} lasts", lambda: rank(entries, foot), repeats, 1.0),
        _timed("compare", lambda: compare(shoelast, foot), repeats, 0.5),
        _timed("customise, transition 10 mm", lambda: customise(shoelast, foot, "therapeutic", fast), repeats, 2.0),
        _timed("customise, transition 20 mm", lambda: customise(shoelast, foot, "therapeutic", slow), repeats, 6.0),
        _import(shoelast, repeats),
        _distance(shoelast_mesh=skin_of(shoelast, Sampling()).mesh(), foot=foot, repeats=repeats),
    ]


def _many(entries: list[LastEntry], count: int) -> list[LastEntry]:
    return [replace(entries[k % len(entries)], id=f"last-{k}") for k in range(count)]


def _import(shoelast: Shoelast, repeats: int) -> LastTiming:
    """A last with a stub as an STL holds it: loose triangles, any heading."""
    body = skin_of(shoelast, IMPORTED).mesh()
    loose = np.concatenate([np.asarray(part.triangles) for part in (body, chuck_stub(shoelast).mesh)]).reshape(-1, 3)
    c, s = np.cos(np.radians(33.0)), np.sin(np.radians(33.0))
    turned = loose @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    soup = trimesh.Trimesh(turned, np.arange(len(loose)).reshape(-1, 3), process=False)
    source = LastSource(soup)
    step = f"import a last of {len(soup.faces)} faces"
    return _timed(step, lambda: shoelast_from_mesh(source, "right", "bench"), repeats, 10.0)


def _distance(shoelast_mesh: trimesh.Trimesh, foot: PreparedFoot, repeats: int) -> LastTiming:
    """Signed distances of 100,000 points beside trimesh's for 2,000 of them, scaled up."""
    points: Floats = np.random.default_rng(1).choice(foot.shell.xyz, 100_000)
    mesh = DistanceMesh(np.asarray(shoelast_mesh.vertices), np.asarray(shoelast_mesh.faces))
    ours = _timed("signed distance of 100,000 points", lambda: mesh.nearest(points), repeats, None)
    few = points[:2000]
    theirs = _timed("", lambda: trimesh.proximity.signed_distance(shoelast_mesh, few), 1, None)
    return replace(ours, baseline="trimesh (2,000 points, times 50)", baseline_s=50.0 * theirs.wall_s[0])


def _timed(step: str, work: Callable[[], object], repeats: int, target_s: float | None) -> LastTiming:
    work()
    wall: list[float] = []
    cpu: list[float] = []
    for _ in range(repeats):
        begin, begin_cpu = time.perf_counter(), time.process_time()
        work()
        wall.append(time.perf_counter() - begin)
        cpu.append(time.process_time() - begin_cpu)
    return LastTiming(step, (min(wall), float(np.median(wall))), min(cpu), target_s)
