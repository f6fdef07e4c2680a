"""Mistakes in a controller: errors, gains, look-ahead, goals."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

STEERING = {
    "turn-away": Cause(
        "The robot turns away from its way, and the farther off it is, the more.",
        "The error has the wrong sign.",
        "If the point lies to the left, the robot has to turn left: omega is positive.",
    ),
    "goal-away": Cause(
        "At the goal the robot turns away from the heading that it should have.",
        "The error there has the wrong sign.",
        "It is goal[2] - heading: if the goal looks farther to the left, omega is positive.",
    ),
    "turn-unsigned": Cause(
        "The robot turns to the left, on whichever side its way lies.",
        "The error has lost its sign: an arc cosine or a size has none.",
        "arctan2 tells left from right: its first argument is negative on the right.",
    ),
    "gain-delay": Cause(
        "The robot drives in wavy lines, or turns sluggishly.",
        "The gain does not fit the delay: what is too high swings, what is too low is late.",
        "The longer the delay, the smaller the gain: 0.25 / delay.",
    ),
    "gain-more": Cause(
        "How strongly the robot turns depends on its speed, or on how far it looks ahead.",
        "The error is multiplied or divided by more than the gain.",
        "Turn with gain · error, where the gain is 0.25 / delay: speed and ahead are not in it.",
    ),
    "goal-heading": Cause(
        "At the goal the robot looks in any direction.",
        "The goal's heading is forgotten, or the goal never counts as reached.",
        "Where the place is reached, only the heading is left: turn to goal[2].",
    ),
    "goal-place": Cause(
        "The robot stops where its goal is not, or drives on where it is.",
        "How far the goal is away is not the length of (dx, dy).",
        "Nearer than 10 mm means a circle: math.hypot(dx, dy) < 0.01.",
    ),
    "goal-reach": Cause(
        "The robot stops before it is at its goal.",
        "It counts as arrived by something else than 10 mm: by the look-ahead distance, or where "
        "the way's last point is the nearest one.",
        "Nearer than 10 mm: math.hypot(goal[0] - x, goal[1] - y) < 0.01.",
    ),
    "goal-early": Cause(
        "The robot turns to the goal's heading long before it is there.",
        "On the way the error is that of the goal's heading.",
        "On the way the error is the direction to the point, less the robot's heading.",
    ),
    "goal-rooted": Cause(
        "The robot stops before it is at its goal.",
        "The goal counts as reached from 100 mm on, as where a squared distance is compared with "
        "0.01.",
        "Compare a distance with 0.01, or its square with 0.01**2.",
    ),
    "map-frame": Cause(
        "It goes well about the map's origin, and badly elsewhere.",
        "Points of the map are taken as if they were seen from the robot: its place is not taken "
        "off where it should be.",
        "Take the robot's x and y off a point of the way first; only what is left has a distance "
        "and a direction, and may be turned by its heading.",
    ),
    "distance": Cause(
        "Beside its way, the robot aims at another point than it should.",
        "How far a point is away is not the length of (dx, dy): both are added, or one of them is "
        "taken.",
        "Points that are equally far away lie on a circle: math.hypot(dx, dy).",
    ),
    "look-behind": Cause(
        "The robot turns around and drives back to where it came from.",
        "The look-ahead point lies behind the robot.",
        "Search from the nearest point on, towards the goal.",
    ),
    "ahead-axis": Cause(
        "Where its way leads back, the robot aims at another point than it should.",
        "A point counts as ahead by its x, on the map or as the robot sees it, and not by its "
        "place on the way.",
        "Search from the nearest point on, in the way's own order.",
    ),
    "no-look-ahead": Cause(
        "The robot jerks to and fro across its way.",
        "It aims at a point that is too near.",
        "Take the first point that is farther than ahead from the robot, both in metres.",
    ),
    "corners-cut": Cause(
        "The robot cuts all corners, through whatever is there.",
        "It aims at the goal, and not at its way.",
        "Take the first point that is far enough, not the last one.",
    ),
    "own-heading": Cause(
        "It goes well while the robot looks along x, and badly otherwise.",
        "The robot's own heading is not taken off the direction.",
        "The error is direction - heading: how far the robot still has to turn.",
    ),
    "bearing-axes": Cause(
        "The robot turns to the wrong side of each diagonal.",
        "The direction is worked out with x and y exchanged.",
        "arctan2 wants y first: arctan2(dy, dx).",
    ),
    "half-plane": Cause(
        "Where the way leads some ways the robot follows it, where it leads others it turns away.",
        "The direction is made of a ratio, as dy / dx, which is the same for two directions.",
        "arctan2(dy, dx) knows all directions; arctan, arc sine and arc cosine only half of them.",
    ),
    "way-direction": Cause(
        "Beside its way the robot drives along with it, and does not come back.",
        "The direction is the way's own, from one of its points to another.",
        "It has to lead from the robot to the point: arctan2(py - y, px - x).",
    ),
    "bearing-back": Cause(
        "The robot turns its back to its way.",
        "The direction is that from the point to the robot.",
        "Subtract the robot's place from the point's, not the other way round.",
    ),
    "points-counted": Cause(
        "How far it looks ahead depends on how dense the way's points are.",
        "It aims a fixed number of points ahead.",
        "Take the first point, from the nearest on, that is farther than `ahead` from the robot.",
    ),
    "ahead-along": Cause(
        "Beside its way, the robot looks farther ahead than it should.",
        "The look-ahead distance is measured from the way's nearest point, not from the robot.",
        "The point is farther than `ahead` from the robot's own place.",
    ),
    "ahead-about": Cause(
        "The robot aims now at a nearer, now at a farther point than it should.",
        "It takes the point whose distance is the most like `ahead`.",
        "Take the first point, from the nearest on, that is farther than `ahead`.",
    ),
    "end-lost": Cause(
        "Close to its goal the robot turns round, or does not get there.",
        "Where no point of the way is far enough, it aims at another one than the last.",
        "Which point does your search give if it finds none? It has to be path[-1].",
    ),
    "drives-away": Cause(
        "With the point behind it, the robot drives away from it.",
        "The size of the cosine is taken, and not its sign.",
        "max(0, cos(error)) lets it turn first.",
    ),
    "ahead-rooted": Cause(
        "The robot looks much too far ahead.",
        "A squared distance is compared with `ahead` itself.",
        "Compare a distance with ahead, or its square with ahead**2.",
    ),
    "ahead-squared": Cause(
        "The robot jerks to and fro across its way.",
        "A distance is compared with the square of `ahead`, which is much smaller.",
        "Compare a distance with ahead, or its square with ahead**2.",
    ),
    "arc": Cause(
        "How strongly the robot turns depends on how fast it is, or on how far away the point is.",
        "It turns as an arc does, by a curvature or a radius, or by how far a point is to the "
        "side.",
        "Turn with gain · error, where the error is an angle and gain = 0.25 / delay.",
    ),
    "turn-sine": Cause(
        "Where the robot looks the wrong way, it hardly turns.",
        "It turns by the sine of the error or by an arc sine, which is small again behind the "
        "robot.",
        "Turn with gain · error; the error itself is brought back to -π to π.",
    ),
    "limited": Cause(
        "The robot turns or drives more slowly than it should where much is to be done.",
        "Speed or turning speed is cut off at a limit, which the lesson does not have.",
        "Return gain · error and speed · cos(error) as they are.",
    ),
    "full-speed": Cause(
        "The robot drives off while it looks in another direction, and comes back in a wide bow.",
        "The speed does not heed the error.",
        "Drive with speed times cos(error): across its way a robot only turns.",
    ),
    "speed-angle": Cause(
        "How fast the robot drives depends on where it looks on the map.",
        "The speed heeds another angle than the error: the robot's heading, or a direction on the "
        "map.",
        "Drive with speed · cos(error): it is the same error that the robot turns by.",
    ),
    "speed-shape": Cause(
        "Where it has to turn, the robot drives too fast or too slowly.",
        "The speed falls with the error, but not as its cosine does.",
        "Drive with speed · cos(error), and 0 where that is negative.",
    ),
    "backwards": Cause(
        "With the point behind it, the robot backs.",
        "The cosine is negative there.",
        "max(0, cos(error)) lets it turn first.",
    ),
    "drives-on": Cause(
        "The robot does not stop at its goal.",
        "At the goal there is still a speed.",
        "Where the place is reached, the speed is 0.",
    ),
}
