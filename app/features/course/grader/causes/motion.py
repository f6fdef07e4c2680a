"""Mistakes in odometry and motion."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

MOTION = {
    "M1": Cause(
        "All particles shift in the same direction, wherever they look.",
        "The step is not turned into each particle's own heading.",
        "Where do the heading and the step meet in your code? Each particle needs its own cosine "
        "and sine.",
    ),
    "M2": Cause(
        "Straight lines are right, but on arcs the path drifts inwards.",
        "The way is taken along the heading after the turn.",
        "While it drives an arc the robot looks from the old heading to the new one. Which heading "
        "does it have on the average?",
    ),
    "M3": Cause(
        "The cloud bursts when the robot backs slowly.",
        "Backing counts as a half turn, a way ahead, and a half turn back; the half turns bring "
        "their noise.",
        "For a step backwards, let the way be negative and the first rotation small.",
    ),
    "middle-wrapped": Cause(
        "Where the heading jumps from π to -π, the robot drives the other way.",
        "The direction half-way is the mean of two headings, one of them already brought back to "
        "-π to π.",
        "Add half of the turn to the old heading; bring back the new heading last.",
    ),
    "M4": Cause(
        "The robot wanders off while it turns on the spot.",
        "The way is not the mean of both wheels: one that rolls back counts as if it rolled ahead, "
        "or one of them alone counts.",
        "One wheel rolls ahead and the other back: what does the middle between them do? Mind the "
        "signs.",
    ),
    "spin-moves": Cause(
        "The robot wanders off while it turns on the spot.",
        "A turn on the spot moves x and y.",
        "The way of a turn on the spot is 0: what do cosine and sine get multiplied with there?",
    ),
    "M5": Cause(
        "The cloud never spreads; soon all particles are one.",
        "All particles get the same noise, or none.",
        "Draw one random number for each particle: rng.standard_normal(len(poses)).",
    ),
    "turn-lost": Cause(
        "The robot never turns, whatever its wheels do.",
        "The heading that comes back is the one from before.",
        "The new heading is the old one plus the turn.",
    ),
    "straight-lost": Cause(
        "The robot turns and drives arcs, but never straight ahead.",
        "Where both wheels roll alike, the pose stays as it was.",
        "A way without a turn is still a way: what does your code do where the turn is 0?",
    ),
    "spin-lost": Cause(
        "The robot drives and takes arcs, but never turns on the spot.",
        "Where the middle of the axle stays, the pose stays as it was.",
        "A turn without a way is still a turn: what does your code do where the way is 0?",
    ),
    "turn-summed": Cause(
        "Driving straight ahead turns the robot.",
        "The turn is made of the sum of the wheels' ways, not of their difference.",
        "If both wheels roll alike, how far does the robot turn?",
    ),
    "way-for-turn": Cause(
        "The robot turns where it should drive ahead, and drives where it should turn.",
        "Sum and difference of the wheels' ways are exchanged.",
        "If both wheels roll alike, does the robot drive, or turn?",
    ),
    "axis-lost": Cause(
        "The robot never leaves a line.",
        "One of x and y stays as it was.",
        "A way has a part along x and one along y: cosine and sine of the heading.",
    ),
    "spin-noiseless": Cause(
        "The cloud does not spread while the robot turns on the spot.",
        "A step without a way has no noise.",
        "A turn on the spot slips, too: alpha1 is for that. Draw noise for each step.",
    ),
    "noise-lost": Cause(
        "The cloud is too narrow in one direction.",
        "One of rotation, way and rotation has no noise, or its noise is not used.",
        "Three random numbers for each particle: follow each of them to the result.",
    ),
    "one-particle": Cause(
        "The cloud shrinks to a single place at each step.",
        "All particles move from the place of one of them.",
        "Each particle moves from its own place: poses[:, 0] and poses[:, 1].",
    ),
    "back-ahead": Cause(
        "Backing drives the cloud ahead.",
        "A step backwards has a positive way.",
        "For a step with dx < 0 let the way be negative.",
    ),
    "zero-back": Cause(
        "The cloud bursts while the robot turns on the spot.",
        "A step without a way counts as one backwards: half a turn to its end, and half a turn "
        "back, with their noise.",
        "Backwards is dx < 0 alone: atan2(-0.0, -0.0) is -π, and not 0.",
    ),
    "back-twice": Cause(
        "Backing drives the cloud ahead.",
        "The way of a step backwards is negative, and its first rotation is half a turn as well: "
        "both together drive ahead.",
        "If the way is negative, the rotation is that of (-dx, -dy).",
    ),
    "noise-on-place": Cause(
        "The cloud is a heap, not a banana.",
        "Noise goes to x and y, where it belongs to the way, or to the side as well.",
        "Noise belongs to the first rotation, the way and the second rotation; x and y come from "
        "those.",
    ),
    "one-wheel-turns": Cause(
        "Driving straight ahead turns the robot.",
        "The turn is that of one wheel alone.",
        "The robot turns by the difference of both wheels' ways: right minus left.",
    ),
    "way-length": Cause(
        "On arcs the cloud comes too far, or not far enough.",
        "The way is not the length of the step.",
        "The step goes dx ahead and dy to the side: how long is that? hypot(dx, dy).",
    ),
    "old-heading": Cause(
        "On arcs the path drifts outwards.",
        "The way is taken along the heading before the turn.",
        "While it drives an arc the robot looks from the old heading to the new one. Which heading "
        "does it have on the average?",
    ),
    "way": Cause(
        "The robot goes too far, or not far enough.",
        "The way of the robot's middle is not the mean of both wheels' ways.",
        "Let both wheels roll 30 mm: how far does the middle go?",
    ),
    "brackets": Cause(
        "The numbers have the wrong size.",
        "Only a part of a sum or of a difference is divided.",
        "Without brackets a + b / c is a + (b / c). What is to be divided as a whole?",
    ),
    "turn-sign": Cause(
        "The robot turns the wrong way.",
        "Left and right are exchanged in the turn.",
        "Theta grows anticlockwise: which wheel rolls farther when the robot turns left?",
    ),
    "turn-one-way": Cause(
        "The robot turns to the same side whichever wheel rolls farther.",
        "The turn has lost its sign: only its size counts.",
        "right - left is negative where the robot turns to the right, and has to stay so.",
    ),
    "half-for-way": Cause(
        "The robot comes to the right place, and looks in a wrong direction there.",
        "The half of the turn by which the way's direction is found is in the new heading, too, "
        "or alone.",
        "Half of the turn is for x and y; the new heading is the old one plus the whole turn, "
        "once.",
    ),
    "track": Cause(
        "Each turn is too large or too small by the same factor.",
        "The difference of the wheels is divided by something else than the track.",
        "For a full turn on the spot each wheel rolls π times the track.",
    ),
    "sine": Cause(
        "The robot drives to the side instead of ahead.",
        "Sine and cosine are exchanged.",
        "At heading 0 the robot looks along x. Which of the two is 1 there?",
    ),
    "arc-sine": Cause(
        "Straight ahead all is right; on an arc the robot goes to the side.",
        "In the formula of the arc, or for its centre, sines and cosines are exchanged.",
        "A robot at heading 0 that turns a little goes along x: radius · (sin(new) - sin(old)) "
        "along x, radius · (cos(old) - cos(new)) along y.",
    ),
    "same-function": Cause(
        "All go along one diagonal, wherever they look.",
        "x and y take the same function of the heading: cosine twice, or sine twice.",
        "At heading 0 nothing goes along y: x takes the cosine, y the sine.",
    ),
    "start-lost": Cause(
        "Each step begins at the origin again.",
        "The pose before the step is not added.",
        "The result is the old pose plus the step.",
    ),
    "rotation-lost": Cause(
        "Headings are wrong after an arc.",
        "One of the two rotations is left out.",
        "A step is a rotation, a way and another rotation; the heading takes both rotations.",
    ),
    "second-turn": Cause(
        "Headings are wrong after an arc.",
        "The second rotation is not what the first one leaves of the turn: the first one is not "
        "taken off, or added to it.",
        "Both rotations together are the turn: how much is left after the first?",
    ),
    "variances": Cause(
        "The cloud has another size than the motion's noise makes.",
        "One of the three variances is another sum than in the stub.",
        "Compare them with the stub, term by term: what is squared, and what is added?",
    ),
    "variance": Cause(
        "The cloud is far too narrow, or far too wide.",
        "A variance is used as a standard deviation.",
        "The sums with the alphas are variances. What does standard_normal have to be multiplied "
        "with?",
    ),
    "alphas": Cause(
        "The cloud spreads in the wrong direction.",
        "The alphas stand at the wrong places.",
        "alpha1 and alpha2 make the noise of rotations, alpha3 and alpha4 that of the way; alpha1 "
        "and alpha4 go with rotations squared, alpha2 and alpha3 with the way squared.",
    ),
    "rooted-twice": Cause(
        "The cloud is far too wide.",
        "A standard deviation is used where a variance is due: the root is drawn twice.",
        "normal wants a standard deviation, and a covariance holds variances.",
    ),
    "noise-scaled": Cause(
        "The whole cloud is too narrow, or too wide, by one and the same factor.",
        "The noise has not the standard deviation that the variances give.",
        "What is drawn before it is multiplied has to have the standard deviation 1, as "
        "rng.standard_normal has; rng.random() - 0.5 has 0.29.",
    ),
    "noise-form": Cause(
        "The cloud is shifted, or has sharp ends.",
        "The noise is not normally distributed about zero.",
        "Use rng.standard_normal, as it is.",
    ),
    "axes-apart": Cause(
        "The cloud has another shape than the motion's noise makes.",
        "x and y go different ways, or in different directions: each draws its own noise, or one "
        "of them has none.",
        "A particle goes one way in one direction: the same two numbers make its x and its y.",
    ),
    "before-rotation": Cause(
        "On arcs the path drifts outwards.",
        "The way is taken along the heading before the first rotation.",
        "The first rotation turns the particle towards the step's end; then it goes.",
    ),
    "after-turn": Cause(
        "Straight lines are right, but on arcs the path drifts inwards.",
        "The way is taken along the heading after both rotations.",
        "The first rotation turns the particle towards the step's end; then it goes, and turns the "
        "rest afterwards.",
    ),
    "half-way": Cause(
        "On many arcs the cloud comes to a wrong place.",
        "The way is taken along the heading half-way, as lesson 1 does; here the first rotation "
        "has turned to the step's end already.",
        "The direction is the heading plus the first rotation: no half is needed.",
    ),
    "rotations-of-turn": Cause(
        "On arcs the cloud has another shape than the motion's noise makes.",
        "The noise of a rotation is made of the whole turn, or of both rotations together.",
        "Each rotation has a variance of its own: of rot1 for the first, of rot2 for the second.",
    ),
    "noises-cancel": Cause(
        "Headings differ less than they should: what one rotation turns too much, the other turns "
        "back.",
        "The noise of the first rotation is not in the new heading: the second rotation is what "
        "the noisy first one leaves of the turn, or the whole turn is added.",
        "First both rotations as they were measured: rot2 = turn - rot1. Then the noise of each, "
        "under other names.",
    ),
    "noise-of-noise": Cause(
        "The cloud is too wide, the more so the larger its noise is.",
        "A variance is made of a way or a rotation that has its noise already.",
        "Work out all three variances first, of the step as it was measured; then add the noise, "
        "under other names.",
    ),
    "same-draw": Cause(
        "The cloud has another shape: errors that have nothing to do with each other go along.",
        "One random number serves for two or three of rotation, way and rotation.",
        "Draw three times for each particle.",
    ),
}
