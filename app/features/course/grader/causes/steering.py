"""Mistakes in a controller: errors, gains, look-ahead, goals."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

STEERING = {
    "turn-away": Cause(
        "The robot turns away from its way, and the farther off it is, the more.",
        "The error has the wrong sign.",
        "If the point lies to the left, the robot has to turn left: omega is positive.",
    ),
    "gain-delay": Cause(
        "The robot drives in wavy lines, or turns sluggishly.",
        "The gain does not fit the delay: what is too high swings, what is too low is late.",
        "The longer the delay, the smaller the gain: 0.25 / delay.",
    ),
    "goal-heading": Cause(
        "At the goal the robot looks in any direction.",
        "The goal's heading is forgotten.",
        "Where the place is reached, only the heading is left: turn to goal[2].",
    ),
    "goal-place": Cause(
        "The robot stops where its goal is not, or drives on where it is.",
        "How far the goal is away is not the length of (dx, dy).",
        "Nearer than 10 mm means a circle: math.hypot(dx, dy) < 0.01.",
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
    "no-look-ahead": Cause(
        "The robot jerks to and fro across its way.",
        "It aims at a point that is too near.",
        "Take the first point that is farther than ahead from the robot.",
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
    "turn-sine": Cause(
        "Where the robot looks the wrong way, it hardly turns.",
        "It turns by the sine of the error, which is small again behind the robot.",
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
