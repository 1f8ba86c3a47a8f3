"""Lasts as digitisers leave them, made from built-in ones, so that the truth is known."""

from dataclasses import dataclass, field

import manifold3d
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from footscan.shoelast.model import Shoelast
from footscan.shoelast.skin import Sampling, skin_of


@dataclass(frozen=True)
class Wear:
    """What is done to the mesh. Lengths in mm."""

    sampling: Sampling = field(default_factory=lambda: Sampling(300, 150, 50))
    noise: float = 0.0
    fragments: int = 0
    crumbs: int = 0
    holes: int = 0
    flipped: float = 0.0
    inverted: bool = False
    fins: int = 0
    stub: bool = False
    toe_centre: bool = False
    turn: bool = False
    scale: float = 1.0
    seed: int = 1


def digitise(shoelast: Shoelast, wear: Wear) -> trimesh.Trimesh:
    """A mesh of the real last (y to the left), worn."""
    rng = np.random.default_rng(wear.seed)
    skin = skin_of(shoelast, wear.sampling)
    xyz, faces = _shaken(skin.xyz_shoelast, skin.faces, wear, rng)
    if wear.stub or wear.toe_centre:
        xyz, faces = _with_knobs(xyz, faces, shoelast, wear)
    xyz = xyz + rng.normal(0.0, wear.noise, xyz.shape) if wear.noise else xyz
    if shoelast.side == "left":
        xyz, faces = xyz * np.array([1, -1, 1]), faces[:, ::-1]
    faces = _holed(xyz, faces, wear.holes, rng)
    faces = faces[:, ::-1] if wear.inverted else faces
    if wear.flipped:
        which = rng.random(len(faces)) < wear.flipped
        faces = np.where(which[:, None], faces[:, ::-1], faces)
    xyz, faces = _fragmented(xyz, faces, wear.fragments, rng)
    xyz, faces = _with_debris(xyz, faces, wear, rng)
    if wear.turn:
        xyz = xyz @ Rotation.random(random_state=wear.seed).as_matrix().T + rng.uniform(-300, 300, 3)
    return trimesh.Trimesh(xyz / wear.scale, np.ascontiguousarray(faces), process=False)


def _shaken(xyz, faces, wear, rng):
    """Put vertices and faces into another order."""
    del wear
    order = rng.permutation(len(xyz))
    inverse = np.empty_like(order)
    inverse[order] = np.arange(len(order))
    return xyz[order], inverse[faces][rng.permutation(len(faces))]


def _with_knobs(xyz, faces, shoelast, wear):

    def solid(mesh):
        return manifold3d.Manifold(
            manifold3d.Mesh64(np.ascontiguousarray(mesh.vertices), np.ascontiguousarray(mesh.faces, dtype=np.uint64))
        )

    body = solid(trimesh.Trimesh(xyz, faces, process=False))
    if wear.stub:
        back = shoelast.upper.grid(np.array([0.0]), np.linspace(0, 1, 51))[22, 0]
        box = trimesh.creation.box(extents=[25.0, 14.0, 24.0])
        box.apply_translation(back + np.array([-19.0 + 12.5, 0.0, 0.0]))
        body += solid(box.subdivide().subdivide().subdivide())
    if wear.toe_centre:
        front = shoelast.upper.grid(np.array([0.5]), np.linspace(0, 1, 101))[:, 0]
        at = front[front[:, 0].argmax()]
        pin = trimesh.creation.cylinder(radius=4.0, height=12.0, sections=48)
        pin.apply_transform(trimesh.geometry.align_vectors([0, 0, 1], [1, 0, 0]))
        pin.apply_translation(at + np.array([2.0, 0.0, 0.0]))
        body += solid(pin)
    mesh = body.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts, dtype=np.int64)


def _holed(xyz, faces, holes, rng):
    middle = xyz[faces].mean(axis=1)
    keep = np.ones(len(faces), dtype=bool)
    for _ in range(holes):
        keep &= np.linalg.norm(middle - middle[rng.integers(len(faces))], axis=1) > rng.uniform(1.5, 4.0)
    return faces[keep]


def _fragmented(xyz, faces, count, rng):
    """Cut into patches that share no vertices."""
    if count == 0:
        return xyz, faces
    middle = xyz[faces].mean(axis=1)
    centres = middle[rng.integers(len(faces), size=count)]
    label = np.argmin(((middle[:, None] - centres) ** 2).sum(-1), axis=1)
    key, place = np.unique(label[:, None] * len(xyz) + faces, return_inverse=True)
    return xyz[key % len(xyz)], place.reshape(-1, 3)


def _with_debris(xyz, faces, wear, rng):
    parts, corners, size = [xyz], [faces], len(xyz)
    for _ in range(wear.crumbs):
        blob = trimesh.creation.icosphere(1, 0.4)
        parts.append(blob.vertices + xyz[rng.integers(len(xyz))] + rng.normal(0, 8, 3))
        corners.append(blob.faces + size)
        size += len(blob.vertices)
    for _ in range(wear.fins):
        face = faces[rng.integers(len(faces))]
        parts.append((xyz[face].mean(axis=0) + rng.normal(0, 0.5, 3))[None])
        corners.append(np.array([[face[0], face[1], size]]))
        size += 1
    return np.vstack(parts), np.vstack(corners)
