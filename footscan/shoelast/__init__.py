"""Shoelasts: model, library, import, comparison with a foot, customising, export. May use `foot`.

The frame `xyz_shoelast` (mm): x from heel to toe along the axis of the bottom, y medial, z up from the ground; the last
stands on its tread point with its seat at its heel height, and x = 0 is the rearmost point of its back (without a chuck
stub). As in the foot frame y is medial for both sides, so a left last is held mirrored; every file that leaves is
mirrored back.
"""
