"""Poses in symbols or numbers: (x, y, heading) in the plane, (x, y, heading, z, pitch, roll) in space.

A pose in space is turned about its own z by heading, then about its own y by pitch, then about its own x by roll. The
chart is singular where the body stands upright (pitch of a quarter turn), and nowhere else: headings count whole turns
as in the plane, which rotation vectors cannot, and the first three numbers mean the same in both.
"""

from __future__ import annotations

import casadi as ca


def rotation(pose: ca.SX) -> ca.SX:
    """Rotation matrix (2, 2) or (3, 3)."""
    c, s = ca.cos(pose[2]), ca.sin(pose[2])
    if pose.numel() == 3:
        return ca.vertcat(ca.horzcat(c, -s), ca.horzcat(s, c))
    (cp, sp), (cr, sr) = ((ca.cos(pose[i]), ca.sin(pose[i])) for i in (4, 5))
    return ca.vertcat(
        ca.horzcat(c * cp, c * sp * sr - s * cr, c * sp * cr + s * sr),
        ca.horzcat(s * cp, s * sp * sr + c * cr, s * sp * cr - c * sr),
        ca.horzcat(-sp, cp * sr, cp * cr),
    )


def place(pose: ca.SX) -> ca.SX:
    """Where the frame's origin is: (2) or (3)."""
    return pose[:2] if pose.numel() == 3 else pose[[0, 1, 3]]


def placed(pose: ca.SX, points: ca.SX) -> ca.SX:
    """Points (2 or 3, K) of a frame with a pose, in the frame that the pose is given in."""
    return rotation(pose) @ points + ca.repmat(place(pose), 1, points.size2())


def composed(pose: ca.SX, motion: ca.SX) -> ca.SX:
    """The pose after a motion that is given in the frame of `pose`; headings are added, not wrapped."""
    where, heading = placed(pose, place(motion)), pose[2] + motion[2]
    if pose.numel() == 3:
        return ca.vertcat(where, heading)
    turned = rotation(pose) @ rotation(motion)
    wrapped, pitch, roll = _angles(turned)
    beside = wrapped - heading  # small where the body is nearly flat, or whole turns
    return ca.vertcat(where[:2], heading + ca.atan2(ca.sin(beside), ca.cos(beside)), where[2], pitch, roll)


def relative(first: ca.SX, second: ca.SX) -> ca.SX:
    """Pose in space `second` (6) in the frame of `first` (6); its heading is wrapped."""
    back = rotation(first).T
    gone, (heading, pitch, roll) = back @ (place(second) - place(first)), _angles(back @ rotation(second))
    return ca.vertcat(gone[:2], heading, gone[2], pitch, roll)


def _angles(turned: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Heading, pitch and roll of a rotation matrix (3, 3)."""
    return ca.atan2(turned[1, 0], turned[0, 0]), -ca.asin(turned[2, 0]), ca.atan2(turned[2, 1], turned[2, 2])
