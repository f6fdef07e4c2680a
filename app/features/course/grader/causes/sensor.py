"""Mistakes in what is seen, and in how well it fits."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

SENSOR = {
    "S1": Cause(
        "With many rays all weights are zero, and then not a number.",
        "Likelihoods become plain numbers too early; they are too small for a computer.",
        "Add logarithms. Before exp, subtract the largest of them: only ratios of weights count.",
    ),
    "S2": Cause(
        "The worst particles win.",
        "The sign in the exponential is missing: what fits badly counts more.",
        "The farther away from the tape, the less likely: exp of what is that?",
    ),
    "S3": Cause(
        "A perfect fit divides by zero, and all others weigh about the same.",
        "The weight is one over the sum of the errors.",
        "Use the bell curve of each distance, as the lesson has it.",
    ),
    "S4": Cause(
        "It moves, but nothing ever fits.",
        "Degrees are taken for radians, or radians for degrees.",
        "Cosine and sine want radians, and headings and bearings are radians. Which of your angles "
        "are in degrees?",
    ),
    "S5": Cause(
        "The cloud is shifted by a constant.",
        "The place where the field begins is ignored.",
        "The first cell lies at field.origin, and the field's corner at left and bottom of the "
        "extent; neither is (0, 0).",
    ),
    "S6": Cause(
        "The heading makes no difference: particles look anywhere.",
        "The rays are not turned by the particle's heading.",
        "A ray leaves the particle at its heading plus the ray's bearing.",
    ),
    "S7": Cause(
        "All weights stay equal.",
        "The weights are computed, but something else is returned, such as a copy.",
        "Follow one weight from where it is computed to the return. Where is it stored?",
    ),
    "S8": Cause(
        "The cloud collapses at once, often in a wrong place.",
        "Sigma is too small: the bell curve is narrower than the one that was asked for.",
        "Compare the exponent with distance² / (2 sigma²), character by character, brackets too.",
    ),
    "S9": Cause(
        "The estimate is off by some centimetres, in a direction that turns with the robot.",
        "The camera's place on the robot is ignored.",
        "The camera sits camera.forward ahead of the axle, and ranges count from the axle.",
    ),
    "no-logarithm": Cause(
        "The weights are all between 0 and 1.",
        "The likelihood is returned, not its logarithm.",
        "Return the sum of np.log of each ray's likelihood.",
    ),
    "outliers": Cause(
        "One ray that sees a shoe throws out the best particle.",
        "The 0.05 for rays that end anywhere is missing, or inside the exponential.",
        "Each ray's likelihood is 0.95 times the bell curve, plus 0.05.",
    ),
    "density": Cause(
        "Rays count more than they should.",
        "The bell curve is divided by its area.",
        "Here the bell curve is 1 where the distance is 0.",
    ),
    "rows": Cause(
        "The map is mirrored at its diagonal.",
        "Rows and columns are exchanged.",
        "field.distances[row, column]: y makes the row, x the column.",
    ),
    "half-cell": Cause(
        "The cloud is shifted by half a cell.",
        "Positions are rounded to the nearest whole number; cells begin at whole numbers.",
        "Cut the decimals off instead (int, floor, or //).",
    ),
    "mean": Cause(
        "The weights differ too little, and the cloud stays wide.",
        "The logarithms are averaged, or divided by something.",
        "Add the logarithms of all rays; nothing more.",
    ),
    "sum": Cause(
        "The weights hardly differ.",
        "Likelihoods are added. That asks for one ray or another to fit, not for all of them.",
        "All rays have to fit: likelihoods are multiplied, so their logarithms are added.",
    ),
    "square": Cause(
        "Small errors weigh too much.",
        "The distance is not squared in the bell curve.",
        "The exponent is -distance² / (2 sigma²).",
    ),
    "sigma": Cause(
        "The cloud stays too wide.",
        "Sigma is larger than the one that was asked for.",
        "Compare the exponent with distance² / (2 sigma²), character by character, brackets too.",
    ),
    "bearing-sign": Cause(
        "Left and right of the robot are exchanged.",
        "Bearings are subtracted from the heading.",
        "Bearings grow anticlockwise, as headings do: add them.",
    ),
    "heading-sign": Cause(
        "A particle that looks left counts as one that looks right.",
        "The heading is subtracted from the bearings.",
        "Bearings grow anticlockwise, as headings do: add them.",
    ),
    "place-lost": Cause(
        "It makes no difference where a particle is.",
        "The particle's place is not added to the ends of its rays.",
        "A ray begins at the particle's x and y.",
    ),
    "no-return": Cause(
        "One ray without a return spoils all weights.",
        "Infinite ranges are used as if something were there.",
        "Leave those rays out: np.isfinite(ranges) tells which have a return.",
    ),
    "left-right": Cause(
        "The robot sees everything mirrored.",
        "A pixel on the right becomes a bearing to the left.",
        "u grows to the right, bearings grow to the left.",
    ),
    "up-down": Cause(
        "What is near seems far.",
        "Rows of the picture are counted upwards.",
        "v grows downwards: a lower pixel shows floor that is nearer.",
    ),
    "horizon": Cause(
        "The sky becomes tape behind the robot.",
        "A ray that does not fall is followed to the floor all the same.",
        "If the ray points upwards, return math.inf as the range.",
    ),
    "horizon-early": Cause(
        "Far floor counts as sky.",
        "The horizon is put into the middle of the picture.",
        "The camera looks down: its horizon lies above the middle, where a ray stops falling.",
    ),
    "rotation": Cause(
        "The picture's middle is right, but not what lies above or below it.",
        "A sign is wrong where the ray is turned by the tilt.",
        "A ray through a lower pixel falls faster. Does it also go farther ahead, or less far?",
    ),
    "side": Cause(
        "What is seen at the side lies at a wrong place.",
        "The part of the ray to the side is not made longer by the same factor as the others.",
        "A ray that becomes three times as long goes three times as far to the side, too.",
    ),
    "offset-late": Cause(
        "Straight ahead all is right, to the side it is not.",
        "The camera's place is added to the range, not to the way ahead.",
        "First the point on the floor, seen from the axle: x and y. Then its bearing and range.",
    ),
    "exchanged": Cause(
        "Ranges are small, and bearings make no sense.",
        "The function returns bearing and range in the wrong order.",
        "Compare what you return with the stub's description.",
    ),
    "slant": Cause(
        "Ranges are too long nearby, or too short at the sides.",
        "The range is not that on the floor, from below the axle to the point.",
        "The range is the length of (x, y) on the floor; the height does not belong to it.",
    ),
    "tilt": Cause(
        "All ranges are far off.",
        "The tilt is used wrongly: it counts downwards, from straight ahead.",
        "Draw the camera from the side. What does the ray through the picture's middle do?",
    ),
    "pixel-origin": Cause(
        "Everything is seen to one side and below.",
        "Pixels are counted from the corner, not from the picture's middle.",
        "Subtract camera.u0 and camera.v0 first.",
    ),
    "focal": Cause(
        "Bearings are nearly right angles.",
        "Pixels are not divided by the focal length.",
        "camera.focal pixels to the side are one unit to the side, one unit ahead.",
    ),
    "arctan": Cause(
        "Straight ahead becomes sideways.",
        "The arguments of arctan2 are exchanged.",
        "arctan2 takes y first, then x.",
    ),
}
