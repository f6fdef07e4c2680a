"""Mistakes in what is seen, and in how well it fits."""

from __future__ import annotations

from app.features.course.grader.causes.cause import Cause

SENSOR = {
    "S1": Cause(
        "With many rays all weights are zero, and then not a number.",
        "Likelihoods become plain numbers too early; they are too small, or too large, for a "
        "computer.",
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
    "origin-wrong": Cause(
        "The cloud is shifted by a constant.",
        "The place where the field begins is used wrongly: x for y, added instead of subtracted, "
        "or in metres where cells are counted.",
        "A cell's column counts from the origin's x, its row from the origin's y: take it off "
        "first, then divide.",
    ),
    "negative-lost": Cause(
        "On one side of the field no guess fits.",
        "Places whose x or y is negative count as others.",
        "Ends may lie anywhere: take field.origin off, divide by the cell, and keep rows and "
        "columns within the field as the last step.",
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
    "offset-sign": Cause(
        "What lies ahead seems twice the camera's place too near.",
        "The camera's place is taken away, and not added.",
        "The camera sits ahead of the axle: seen from the axle, is a point nearer or farther?",
    ),
    "sigma-multiplied": Cause(
        "Near and far weigh nearly the same.",
        "The exponent is multiplied by sigma², and not divided by it.",
        "-d**2 / 2 * sigma**2 divides by 2 alone. What is to be divided by needs brackets.",
    ),
    "beyond-skipped": Cause(
        "A guess near the border weighs too much, or too little.",
        "A ray that ends beyond the field is left out, or counts as one that missed.",
        "Count such an end at the nearest cell: np.clip(row, 0, rows - 1), and columns likewise.",
    ),
    "no-rays": Cause(
        "Guesses near tape win, whatever the robot sees.",
        "The distance is looked up where the guess itself is, not where its rays end.",
        "A ray leads from the guess as far as its range: work out x and y of its end, and look up "
        "the distance there.",
    ),
    "distances-joined": Cause(
        "One ray that sees a shoe spoils all the others.",
        "The distances of all rays are made one, as their mean, and only then the curve is taken.",
        "Each ray has a likelihood of its own: first the curve of each distance, then the sum of "
        "the logarithms.",
    ),
    "not-fallen": Cause(
        "What is seen lies too near, or too far.",
        "The ray is not followed until it has fallen by the camera's height: it is made longer by "
        "another factor, as of its length or of what it goes ahead.",
        "height / (how far it falls) is the factor: then the ray falls by just the height.",
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
    "beyond": Cause(
        "A ray that ends beyond the field stops the program, or counts at the field's other side.",
        "The index of a cell is not kept within the field.",
        "Count such an end at the nearest cell: np.clip(row, 0, rows - 1), and columns likewise. "
        "Index -1 is the last one.",
    ),
    "hit-share": Cause(
        "The weights differ too much, or too little.",
        "The shares of rays that end at the tape and anywhere are not 0.95 and 0.05.",
        "Each ray's likelihood is 0.95 times the bell curve, plus 0.05.",
    ),
    "bearings-lost": Cause(
        "All rays of a scan point the same way.",
        "The bearings of the rays make no difference.",
        "A ray leaves the particle at its heading plus the ray's own bearing.",
    ),
    "ray-sign": Cause(
        "The rays end behind the robot, or mirrored.",
        "The way along a ray is subtracted, in x or in y or in both.",
        "A ray ends at the particle's place plus range times cosine, plus range times sine.",
    ),
    "map-turned": Cause(
        "The scan fits at a mirrored place.",
        "The map is turned over: rows are counted from the top, or columns from the right.",
        "Row 0 is at the bottom, where y is field.origin[1]; rows grow with y.",
    ),
    "all-missed": Cause(
        "All weights stay equal: each ray counts as one that ended at a shoe.",
        "The distances that are looked up are far too large, as where metres are taken for cells, "
        "or the curve is far too narrow.",
        "How many cells are 0.5 m, at 0.01 m a cell? Print row, column and distance of one ray, "
        "then its likelihood.",
    ),
    "place-axes": Cause(
        "Particles are weighed as if they were elsewhere.",
        "The rays begin at a place whose x and y are exchanged, or are one and the same.",
        "A ray begins at poses[:, 0], poses[:, 1]: the first for x, the second for y.",
    ),
    "cell-off": Cause(
        "The cloud is shifted by a cell.",
        "The cell is one beside the one that holds the end of the ray.",
        "The end at field.origin lies in cell 0, and a cell further in cell 1.",
    ),
    "no-curve": Cause(
        "What is far away from the tape counts more.",
        "The distance itself is used as the fit, without the bell curve.",
        "The fit is exp of minus distance² / (2 sigma²): 1 at the tape, 0 far away.",
    ),
    "log-sign": Cause(
        "The worst particles win.",
        "The logarithm has the wrong sign.",
        "A log-likelihood is negative: the logarithm of a number below 1.",
    ),
    "shared": Cause(
        "The next lesson cannot use the weights: their size is lost.",
        "The log-weights are compared with each other already, or made to sum to one.",
        "Return the sum of the logarithms itself; the loop of lesson 6 does the rest.",
    ),
    "stops-early": Cause(
        "One ray without a return, and those after it make no difference.",
        "The loop ends at the first ray without a return.",
        "continue goes on with the next ray; break ends the loop.",
    ),
    "one-guess": Cause(
        "All weights stay equal.",
        "All guesses get the weight of one of them: the first or the last.",
        "Each guess has its own x, y and heading: where does your code take those of the others?",
    ),
    "accumulated": Cause(
        "Each guess weighs less than the one before.",
        "The sum goes on from one guess to the next.",
        "Begin each guess with a sum of 0.",
    ),
    "one-ray": Cause(
        "All rays but one make no difference.",
        "Only one ray of the scan counts: the best, the worst, the first or the last.",
        "All rays together: their logarithms are added.",
    ),
    "log-base": Cause(
        "All weights are too small, or too large, by the same factor.",
        "The logarithm has another base.",
        "np.log is the natural logarithm, which exp undoes.",
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
    "one-side": Cause(
        "All that is seen lies on the same side of the robot.",
        "The bearing has lost its sign: acos, a root and abs give none.",
        "To the left is positive, to the right negative: arctan2(y, x) keeps the sign of y.",
    ),
    "bearings-unpaired": Cause(
        "Where one ray has no return, the others look elsewhere.",
        "Ranges without a return are left out, but their bearings are not: from there on each "
        "range has the bearing of another ray.",
        "Leave both out: seen = np.isfinite(ranges), then bearings[seen] and ranges[seen].",
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
    "sky": Cause(
        "What is above the horizon seems to lie on the floor.",
        "Above the horizon something else than an infinite range is returned.",
        "Return math.inf as the range there, with any bearing that is a number.",
    ),
    "cartesian": Cause(
        "Rays point anywhere.",
        "Ahead and to the side are returned, x and y, in place of bearing and range.",
        "Bearing and range of a point: arctan2(y, x), and its distance from the axle.",
    ),
    "height-lost": Cause(
        "All ranges are too long by the same factor.",
        "The camera's height makes no difference.",
        "A ray falls by camera.height until it meets the floor: how long does it take for that?",
    ),
    "from-camera": Cause(
        "Bearing and range belong to different places.",
        "One of them counts from the axle, the other one from the camera.",
        "First the point on the floor, seen from the axle: x and y. Then both of that point.",
    ),
    "bearing-in-picture": Cause(
        "What lies at the side is seen too far ahead.",
        "The bearing is that in the picture, as if the camera looked straight ahead from the axle.",
        "Work out the point on the floor first; the bearing is that of its x and y.",
    ),
    "no-arctan": Cause(
        "Bearings are too large at the sides.",
        "The bearing is a ratio of sides, not an angle.",
        "arctan2 makes an angle of y and x.",
    ),
    "no-root": Cause(
        "What is near seems nearer, and what is far farther.",
        "The range is the sum of squares, without its root.",
        "hypot(x, y) is the root of the sum of squares.",
    ),
    "pixel-axes": Cause(
        "The picture lies on its side.",
        "u and v, or the middles u0 and v0, are exchanged.",
        "u counts to the right from u0, v counts down from v0.",
    ),
    "pixels-as-angles": Cause(
        "It is right in the middle of the picture, and less so towards its edges.",
        "Pixels are taken for angles: twice as far is twice the angle.",
        "A pixel's angle has the tangent pixels / focal.",
    ),
    "offset-early": Cause(
        "All ranges are off by a little, the more the higher the camera is.",
        "The camera's place is added before the ray is made longer.",
        "First make the ray as long as it falls to the floor, then add how far ahead the camera "
        "sits.",
    ),
    "rows-lost": Cause(
        "All that lies ahead seems equally far away.",
        "How far up or down the pixel lies makes no difference.",
        "A lower pixel shows nearer floor: where does (v - v0) / focal come in?",
    ),
    "columns-lost": Cause(
        "All that is seen seems to lie straight ahead.",
        "How far to the side the pixel lies makes no difference.",
        "Where does (u - u0) / focal come in?",
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
