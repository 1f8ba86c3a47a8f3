import numpy as np

from footscan.foot.closure import ClosureRule, EdgeShape, closing_arcs, edge_shape

RULE = ClosureRule("curvature-rounded", 16.0, 10.0)
UNKNOWN = np.full(60, np.nan)
AROUND = 2.0 * np.pi * np.arange(60) / 60
OUTWARDS = np.stack([np.cos(AROUND), np.sin(AROUND)], axis=1)


def ball_ring(z_mm: float, radius_mm: float = 20.0) -> np.ndarray:
    flat = 30.0 + np.sqrt(radius_mm**2 - (radius_mm - z_mm) ** 2)
    return np.column_stack([flat * OUTWARDS, np.full(60, z_mm)])


def test_lean_and_bend_of_a_round_edge_are_found() -> None:
    rows = np.stack([ball_ring(z) for z in (8.0, 10.0, 12.5)])

    edge = edge_shape(rows, -OUTWARDS)

    np.testing.assert_allclose(edge.lean_rad, np.arcsin(12.0 / 20.0), atol=0.02)
    np.testing.assert_allclose(edge.bend_per_mm, 1.0 / 20.0, rtol=0.1)


def test_arcs_start_on_the_board_end_at_the_skin_and_never_leave_the_inside() -> None:
    ring = ball_ring(8.0)
    edge = EdgeShape(np.full(60, 0.5), np.full(60, 0.05))

    points, along = closing_arcs(ring, -OUTWARDS, edge, np.full(60, 40.0), UNKNOWN, RULE)
    flat = np.hypot(points[..., 0], points[..., 1])

    np.testing.assert_allclose(points[:, -1], ring, atol=1e-12)
    assert np.all(points[:, 0, 2] == 0.0)
    assert np.all(np.diff(points[..., 2], axis=1) > 0)
    assert np.all(np.diff(flat, axis=1) > 0)
    assert np.all(np.diff(along, axis=1) > 0)
    assert np.all(along[:, 0] == 0.0)
    np.testing.assert_allclose(along[:, -1], 1.0)


def test_arcs_leave_the_seen_skin_at_its_lean() -> None:
    points, _ = closing_arcs(
        ball_ring(8.0), -OUTWARDS, EdgeShape(np.full(60, 0.4), np.full(60, 0.05)), np.full(60, 60.0), UNKNOWN, RULE
    )
    step = points[:, -2] - points[:, -1]
    lean = np.arctan2(-(step[:, :2] * OUTWARDS).sum(axis=1), -step[:, 2])

    assert np.all(lean > 0.4)
    assert np.all(lean < 0.5)


def test_skin_that_leans_outwards_goes_straight_down() -> None:
    rows = np.stack([np.column_stack([(30.0 + 5.0 - 0.3 * z) * OUTWARDS, np.full(60, z)]) for z in (6.0, 9.0, 12.0)])

    edge = edge_shape(rows, -OUTWARDS)

    assert np.all(edge.lean_rad == 0.0)


def test_arcs_keep_within_their_room() -> None:
    ring = ball_ring(18.0)

    edge = EdgeShape(np.full(60, 1.0), np.full(60, 0.2))
    points, _ = closing_arcs(ring, -OUTWARDS, edge, np.full(60, 18.0), UNKNOWN, RULE)

    assert np.linalg.norm(points[:, :, :2] - ring[:, None, :2], axis=2).max() <= 9.0 + 1e-9


def test_skin_reaches_the_board_a_little_inside_the_last_bare_board() -> None:
    ring, edge = ball_ring(8.0), EdgeShape(np.full(60, 0.3), np.full(60, 0.05))
    points, _ = closing_arcs(ring, -OUTWARDS, edge, np.full(60, 60.0), np.full(60, 5.0), RULE)
    inset = np.hypot(ring[:, 0], ring[:, 1])[:, None] - np.hypot(points[..., 0], points[..., 1])

    np.testing.assert_allclose(inset[:, 0], 15.0, atol=1e-9)
    assert np.all(np.diff(inset, axis=1) < 0)
    assert np.all(np.diff(points[..., 2], 2, axis=1) > 0)
    assert np.all(points[:, np.argmin(np.abs(inset[0] - 5.0)), 2] > 1.0)


def test_an_arch_runs_somewhat_further_in_than_its_own_lean_leads() -> None:
    ring, edge = ball_ring(18.0), EdgeShape(np.full(60, 0.8), np.full(60, 0.0))
    points, _ = closing_arcs(ring, -OUTWARDS, edge, np.full(60, 80.0), np.full(60, 6.0), RULE)
    inset = np.hypot(ring[:, 0], ring[:, 1]) - np.hypot(points[:, 0, 0], points[:, 0, 1])

    np.testing.assert_allclose(inset, 1.4 * 18.0 * np.tan(0.8), atol=1e-9)
