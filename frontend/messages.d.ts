// Made from the program's classes of messages by `python -m app.tools.typescript`.

export type Command =
  | CalibrateCommand
  | CancelCommand
  | CloseRecordingCommand
  | DeleteStrokeCommand
  | DiscardMapCommand
  | DriveCommand
  | ExploreCommand
  | FigureEightCommand
  | FilterByHandCommand
  | FilterStepCommand
  | FilterUndoCommand
  | FinishCalibrationCommand
  | FinishMapCommand
  | JoinStrokesCommand
  | MoveEndCommand
  | NavigateCommand
  | OpenRecordingCommand
  | PauseCommand
  | PauseMapCommand
  | PingCommand
  | PlaceCommand
  | RecordCommand
  | ReplayCommand
  | ResetCommand
  | ResumeCommand
  | RouteCommand
  | RunAgainCommand
  | SaveMapCommand
  | ScatterCommand
  | SetCalibrationCommand
  | SetFaultsCommand
  | SetParametersCommand
  | SetParticlesCommand
  | SetPoseCommand
  | SetWallsCommand
  | ShowCommand
  | StartMapCommand
  | StopCommand
  | TakeCommand
  | TakePlaceCommand
  | UndoCalibrationCommand
  | UndoCommand
  | UndoEditCommand
  | UpdateCommand
  | UseFieldCommand;

/** What the token of a request allows. */
export interface AccessMessage {
  role: "drive" | "watch";
  /** Why it only watches, in words, if that is not what its token says. */
  why?: string;
}

/** The command was accepted. */
export interface AckMessage {
  type: "ack";
  id: number | string | null;
  /** The robot's clock when the answer was written, to align the clocks [s]. */
  stamp: number | null;
}

/** A printed board. */
export interface BoardMessage {
  /** chessboard, charuco or aprilgrid. */
  kind?: string;
  /** Squares, or tags, across the page. */
  columns?: number;
  /** Squares, or tags, up the page. */
  rows?: number;
  /** Side of a square, or of a tag [m]. */
  square?: number;
  /** Side of a marker, as a share of the square's (charuco). */
  marker?: number;
  /** Which markers (charuco, aprilgrid). */
  dictionary?: string;
  /** Gap between tags, as a share of a tag's side (aprilgrid). */
  spacing?: number;
}

/**
 * Drive to calibrate the robot, until it is known where its camera is; at most two minutes. It
 * holds as long as drive does, and continues if renewed. At its end the robot is calibrated by
 * what it saw; ``stop`` leaves the calibration as it was.
 */
export interface CalibrateCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "calibrate";
  /** Whether to begin; without it the command only renews a drive that has begun. */
  start?: boolean;
}

/** The running drive of a calibration, or the last one. */
export interface CalibrationDriveMessage {
  /**
   * drive: the robot drives; adjust: it stands, and the calibration is computed; done: it is
   * calibrated; failed: its calibration is as before.
   */
  state: "drive" | "adjust" | "done" | "failed";
  /** How long it has driven [s]. */
  seconds: number;
  /** How long the whole drive is [s]. */
  whole: number;
  /** After this time ``finish_calibration`` is accepted [s]. */
  fewest: number;
  /** How many results there were; ``/api/calibration`` has the newest. */
  adjusted: number;
  /** What is missing so far, or why it failed; null when all is well. */
  message: string | null;
}

/** What is known of the robot: by the last adjusted drive, or by its profile without one. */
export interface CalibrationMessage {
  /** When and from what the robot was calibrated; empty if it is as described. */
  measured: string;
  /** Whether ``undo_calibration`` can go back to another calibration. */
  undoable: boolean;
  unknowns: UnknownMessage[];
  /** By how much these errors may shift the estimated place, in 95 % [m]; null without a drive. */
  position: number | null;
  /** Motions that would determine what is not known yet. */
  advice: string[];
  /** How well the last drive, or what the profile was measured by, fits; empty without both. */
  facts: string[];
  /** What is wrong with it, or may be wrong. */
  remarks: string[];
}

/** End the journey to a goal: the robot stands where it is. */
export interface CancelCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "cancel";
  /** Only a journey that began before this time on the robot's clock [s]; null is any. */
  before?: number | null;
}

/** What is to change of a recording; what is left out stays. */
export interface ChangeMessage {
  name?: string | null;
  notes?: string | null;
}

/** Go back from a recording that the page opened to the robot. */
export interface CloseRecordingCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "close_recording";
}

/** How far the first start is, which compiles functions for this computer. */
export interface CompilingMessage {
  /** Functions that are compiled. */
  done: number;
  /** Functions that are to be compiled, those included. */
  total: number;
}

/** The inflation layer: what each cell costs on a way to a goal, in nav2's numbers. */
export interface CostsMessage {
  x: number;
  /** Lower left corner of the cells in the map [m]. */
  y: number;
  /** Side of a cell [m]. */
  step: number;
  columns: number;
  rows: number;
  /** Walls farther away cost nothing [m]. */
  inflation_radius: number;
  /** How soon the cost falls with the distance [1/m]. */
  cost_scaling_factor: number;
  /**
   * base64 of a byte a cell, row by row from below: 254 is a wall, 253 where the robot cannot
   * turn, 252 to 1 the nearer a wall the more, 0 free.
   */
  cells: string;
}

/** A closed curve, which is driven lap after lap. */
export interface CurveMessage {
  shape: "figure_eight" | "circle" | "square" | "points";
  /**
   * Radius of the circles, or half of the square's side [m]; null is the figure-eight's radius in
   * the settings.
   */
  size?: number | null;
  /**
   * Speed along the curve where nothing asks for less [m/s]; null is the figure-eight's in the
   * settings.
   */
  speed?: number | null;
  /**
   * x, y [m] in the map, of the shape points: the curve leads smoothly through them, and from the
   * last one back to the first.
   */
  points?: [number, number][];
  /**
   * Where a shape begins, and in which direction; null is where the robot stands, as it stands.
   * Circles are driven to the left first, and the square's corners are left ones.
   */
  start?: GoalMessage | null;
}

/** Delete a stroke of tape from the finished map, before it is saved. */
export interface DeleteStrokeCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "delete_stroke";
  /** Its number, from 0 on, in ``/api/mapping``. */
  stroke: number;
  /** Version of that drawing; in another one, the stroke may have another number. */
  version: number;
}

/** Forget the map. */
export interface DiscardMapCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "discard_map";
}

/**
 * Drive; holds for ``cmd_vel_timeout`` unless renewed. Velocities beyond the limits are reduced to
 * them.
 */
export interface DriveCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "drive";
  v: number;
  omega: number;
}

/** Who drives. */
export interface DriverMessage {
  /** Name of the client; null while nobody drives. */
  name: string | null;
  /** Whether it is this connection, or another page of the same browser. */
  mine: boolean;
  /** Whether it is this connection itself. */
  this_page: boolean;
  /** Whether a stop holds: drive commands that only continue those before it are refused. */
  stopped: boolean;
}

/** Where the scanner found tape in a picture. */
export interface EdgesMessage {
  /** Pixel (u, v) where each ray enters the tape; null for a ray that did not count. */
  entry_px: ([number, number] | null)[];
  exit_px: ([number, number] | null)[];
  /** Median width measured over the rays that counted [m]. */
  tape_width: number | null;
}

/** A drawing as the editor takes it; lengths in mm, y up, as in the map. */
export interface EditableDrawingMessage {
  left: number;
  bottom: number;
  width: number;
  height: number;
  /** x, y [mm] and heading [degrees] of the robot. */
  start: [number, number, number];
  strokes: EditableStrokeMessage[];
  /** In the order of painting, below all strokes. */
  fills: EditableFillMessage[];
  /** Other ``data-`` attributes of the drawing. */
  kept: Record<string, string>;
  /** What is not as in the drawing, in words. */
  remarks: string[];
}

/** An area of another tone, which the editor keeps as it is. */
export interface EditableFillMessage {
  /** Its outlines, x and y [mm] in the map frame: what lies within an odd number is filled. */
  rings: [number, number][][];
  grey: number;
  opacity: number;
}

/** A strip of tape, of straight lines and arcs. */
export interface EditableStrokeMessage {
  /**
   * x, y [mm] in the map frame, and how far the tape bends on its way to the next node: the
   * tangent of a quarter of the arc's angle, positive if it turns left; 0 is straight.
   */
  nodes: [number, number, number][];
  closed: boolean;
  /** [mm] */
  width: number;
  /** Brightness, 0 to 255. */
  grey: number;
  /** Lengths of dash, gap, ... [mm]; empty if it has none. */
  dashes: number[];
}

/** The command was refused, and why. */
export interface ErrorMessage {
  type: "error";
  id: number | string | null;
  message: string;
}

/** Where the filter believes the robot is, carried forward to the telemetry's stamp. */
export interface EstimateMessage {
  x: number;
  y: number;
  theta: number;
  /** 9 numbers by rows [m^2, m rad, rad^2]. */
  covariance: number[];
}

/**
 * Drive to see the tape that the map lacks. It holds as long as drive does, and continues if
 * renewed. It ends by itself, back at its start, when the floor between the tape and around it was
 * looked at.
 */
export interface ExploreCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "explore";
  /** Whether to begin; without it the command only renews a drive that has begun. */
  start?: boolean;
}

/** What can be wrong with a simulated robot and its camera. */
export interface FaultsMessage {
  /** Each with its value now; the default is the value at the start. */
  faults: ParameterMessage[];
  /** Values of each named condition of `brickpose evaluate integrity`. */
  conditions: Record<string, Record<string, number | string>>;
}

/** A field that can be chosen. */
export interface FieldEntry {
  name: string;
  /** Whether it is a file of the user's, which can be deleted. */
  own: boolean;
  /** Whether it is a drawing, which can be edited and printed; others have a picture only. */
  drawing: boolean;
  /** When its file was written [s since 1970]; 0 where there is none. */
  changed: number;
}

/** The field, the robot on it, and limits: a page needs them once, and again after a calibration. */
export interface FieldMessage {
  name: string;
  /** xmin, ymin, xmax, ymax [m] of the free part, where robots drive. */
  drive_area: number[];
  /** xmin, ymin, xmax, ymax [m] of ``/api/field.png``. */
  extent: number[];
  /** Where the camera of the 3D view begins [m]; it looks at the middle of ``extent``. */
  view_home: [number, number, number];
  start: PoseMessage;
  /** The robot's outline on the floor [m], in the robot frame. */
  robot_outline: [number, number][];
  /** When and by what the robot was calibrated; empty if it is as described. */
  robot_measured: string;
  /** Whether a simulated robot moves without forces, and no physics engine is installed here. */
  engine_missing: boolean;
  max_v: number;
  max_omega: number;
  /** How long a drive command holds if it is not renewed [s]. */
  drive_timeout: number;
  /** Telemetry older than this [s] does not show the present. */
  stale_after: number;
  /**
   * A longer step between two messages of telemetry [m] was not driven: something was put
   * elsewhere.
   */
  longest_step: number;
  initial_sd_xy: number;
  /** Configured spread of a pose that is set without a spread [m, rad]. */
  initial_sd_theta: number;
  image_width: number;
  /** Size of the camera's picture [px]. */
  image_height: number;
  /** Width of tape that the scanner looks for [m], to compare with ``ScanMessage.tape_width``. */
  tape_width: number;
  /** Each ray as a line of pixels, from its start to its end in the picture. */
  rays_px: [number, number][][];
  /** Names of the features that take part; the page hides what belongs to others. */
  features: string[];
}

/**
 * Drive the open-loop figure-eight. It holds as long as drive does, and continues if renewed. The
 * robot stands until then; after five seconds the figure-eight begins again.
 */
export interface FigureEightCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "figure_eight";
  /** Whether to begin again; that is refused if the robot is known to leave the field. */
  start?: boolean;
  /** Speed along the circles [m/s]; null means as configured. It may change during the drive. */
  speed?: number | null;
}

/**
 * Let the particle filter wait for steps by hand, or work by itself again. Another filter is
 * replaced by it, and it begins at the heaviest place of that one. Odometry gathers meanwhile; the
 * next prediction uses all of it.
 */
export interface FilterByHandCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "filter_by_hand";
  on: boolean;
}

/** State of the filter. */
export interface FilterMessage {
  paused: boolean;
  /** Its name, one of those of the parameter ``filter``. */
  kind: string;
  /** Progress by hand; null while it works by itself. */
  hand?: HandMessage | null;
  /** Measurement updates since the last set_pose, scatter or reset. */
  updates: number;
  /** How many changes of the belief ``undo`` can take back. */
  undoable: number;
  /**
   * What is wrong with a user's own model, with file and line; the robot stands still and the
   * filter pauses until it is fixed.
   */
  broken: string | null;
}

/**
 * Take one step of the particle filter by hand. predict: move the particles by odometry up to the
 * newest picture, with noise. weigh: weigh them by that picture. resample: draw the particles that
 * survive. Each follows the one before it; predict is always possible.
 */
export interface FilterStepCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "filter_step";
  step: "predict" | "weigh" | "resample";
}

/** Take back the last step by hand, random numbers included. */
export interface FilterUndoCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "filter_undo";
}

/** End the calibration's drive, and calibrate the robot by what it has seen so far. */
export interface FinishCalibrationCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "finish_calibration";
}

/** End the drive of the map; all of it is adjusted then. */
export interface FinishMapCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "finish_map";
}

/** The floor's grid, every 0.1 m, as the camera sees it. */
export interface FloorGridMessage {
  lines: GridLineMessage[];
  labels: GridLabelMessage[];
}

/** A goal in the map. */
export interface GoalMessage {
  x: number;
  y: number;
  /** The heading there; null is any. */
  theta?: number | null;
}

/** A distance ahead of the robot's axle, on the line straight ahead. */
export interface GridLabelMessage {
  /** [m] */
  distance: number;
  u: number;
  /** Where it is in the picture [px]. */
  v: number;
}

/** A part of a line on the floor that the picture shows. */
export interface GridLineMessage {
  /** Along it (u, v) [px]. */
  pixels: [number, number][];
  /** Whether it is the line straight ahead of the robot. */
  ahead: boolean;
}

/** Progress of the filter by hand. */
export interface HandMessage {
  /** Changes with each step, forwards or back; ``/api/filter_by_hand`` has the step. */
  number: number;
  /** The last step; null before the first. */
  last: "predict" | "weigh" | "resample" | null;
  /** How many steps can be taken back. */
  undoable: number;
  /** Effective sample size of the current particles. */
  effective: number;
  /** How far the wheels have driven since the last prediction, in the robot frame. */
  ahead: PoseMessage;
}

/** The last step by hand, and what it did to the particles. */
export interface HandStepMessage {
  /** As in telemetry. */
  number: number;
  last: "predict" | "weigh" | "resample" | null;
  /** xmin, ymin, xmax, ymax [m] of the area that x and y in the clouds span. */
  extent: number[];
  /**
   * All particles before the step, packed as ``ParticlesMessage.cloud``; empty before the first
   * step.
   */
  before: string;
  /** The particles after it. */
  after: string;
  /** After predict: where odometry alone would have moved each particle; else empty. */
  noiseless: string;
  /** After resample: the index of each particle's parent, -1 without one; else empty. */
  parents: number[];
  /** After predict: the step by odometry, in the robot frame. */
  moved: PoseMessage | null;
  /** After predict: standard deviations of the noise: ahead, aside and in heading. */
  noise: PoseMessage | null;
  effective_before: number | null;
  /** Effective sample size. */
  effective: number;
}

/** How the scan fits in all directions at a place. */
export interface HeadingsMessage {
  stamp: number;
  thetas: number[];
  /** Log-weight of each, relative to the best. */
  logs: number[];
  seconds: number;
}

/** Whether the program works. */
export interface HealthMessage {
  status: "ok" | "degraded" | "failed";
  detail: string;
  robot: string;
  uptime_s: number;
  step_hz: number;
  /** Present while functions are compiled; there is no robot before that is done. */
  compiling?: CompilingMessage | null;
}

/** One place where the robot may be, carried forward to the telemetry's stamp. */
export interface HypothesisMessage {
  x: number;
  y: number;
  theta: number;
  /** How likely it is, 0 to 1. */
  weight: number;
  /** 9 numbers by rows [m^2, m rad, rad^2]. */
  covariance: number[];
}

/** How far the estimate can be trusted. */
export interface IntegrityMessage {
  /**
   * certain: one place, with a narrow bound; given: as somebody gave it, and not confirmed by
   * scans yet; approximate: one place, with a wide bound or none; ambiguous: several places look
   * alike; searching: no place stands out; lost: the place that was known does not fit any more.
   */
  state: State;
  /**
   * The robot is within this distance of the estimate [m], in 99.9 % of pictures; null if nothing
   * is claimed.
   */
  radius: number | null;
  /** Its heading is within this angle of the estimate's [rad]; null if nothing is claimed. */
  heading_bound: number | null;
  /** Reasons for doubt in plain words, the newest first; empty if there are none. */
  alerts: string[];
}

/** Join two strokes of the finished map where their ends are nearest, before it is saved. */
export interface JoinStrokesCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "join_strokes";
  stroke: number;
  /** Their numbers, from 0 on, in ``/api/mapping``. */
  other: number;
  /** Of that drawing. */
  version: number;
}

/** A file that was kept among the user's fields. */
export interface KeptFieldMessage {
  name: string;
  /** What of the file is no part of the field, in words. */
  remarks: string[];
}

/** How the scan fits all over the field, at one heading. */
export interface LandscapeMessage {
  stamp: number;
  model: string;
  x: number;
  /** Middle of the first cell [m]. */
  y: number;
  /** Side of a cell [m]. */
  step: number;
  columns: number;
  rows: number;
  theta: number;
  /**
   * Log-weight of the value 0 in ``cells``, relative to the best cell, which is 255; smaller ones
   * are 0, too.
   */
  lowest: number;
  /** base64 of one byte per cell, row by row from the lowest y. */
  cells: string;
  /** The best cell. */
  best: PoseMessage;
  /** How long it took to compute [s]. */
  seconds: number;
}

/** The texts of one language. */
export interface LanguageMessage {
  /** Its code, as ``de``. */
  language: string;
  /** Which form a number n takes: an expression in C, as gettext has it. */
  plural: string;
  /** Between a number's whole part and its decimals. */
  point: string;
  /** By English text: one form, or each plural's; places for values are ``{names}``. */
  texts: Record<string, string[]>;
}

/** How much of each kind of picture there is, 0 to 1; all are 1 when nothing is missing. */
export interface LensBarsMessage {
  x: number;
  y: number;
  size: number;
  tilt: number;
}

/** Calibrate the lens by the pictures so far. */
export interface LensCalibrateRequest {
  type: "calibrate";
}

/** What was found in the newest picture that was looked at. */
export interface LensLookMessage {
  /** Stamp of its exposure [s]. */
  stamp: number;
  /** The board's corners; empty if it was not found. */
  corners: [number, number][];
  /**
   * Whether the picture counts, and if not: the board moves, there is one like it, or it is
   * useless.
   */
  verdict: "taken" | "moving" | "known" | "refused";
  /** Why it does not count; empty if it does. */
  words: string;
}

/** A lens that was calibrated. */
export interface LensMessage {
  model: string;
  width: number;
  /** Size of the pictures [px]. */
  height: number;
  pictures: number;
  /** The board that it was calibrated by, in words. */
  board: string;
  /** How well each model fits. */
  ratings: LensRatingMessage[];
  parameters: LensParameterMessage[];
  corners: [number, number][];
  /** Distance of each corner from where the lens projects it [px]. */
  errors: [number, number][];
  outlines: [number, number][][];
  refused: LensRefusalMessage[];
  /** What more pictures should show; empty if nothing. */
  missing: string[];
}

/** One number of the lens. */
export interface LensParameterMessage {
  name: string;
  value: number;
  /** Half of the 95 % interval. */
  interval: number;
}

/** How well a model of lenses fits. */
export interface LensRatingMessage {
  model: string;
  /** Root mean square error in pictures that were held out [px]; null if it failed there. */
  held_out_px: number | null;
  /** The same in the pictures that it was fitted to: the reprojection error [px]. */
  own_px: number;
}

/** A picture that was taken and does not count after all. */
export interface LensRefusalMessage {
  picture: string;
  reason: string;
}

/** Put the lens into the real robot's profile. */
export interface LensSaveRequest {
  type: "save";
}

/** Search for this board, and forget the pictures so far. */
export interface LensStartRequest {
  type: "start";
  board: BoardMessage;
}

/**
 * Progress of a calibration, by the WebSocket ``/api/lens``, which takes the requests as well. It
 * is sent after each picture to all clients that may drive.
 */
export interface LensStatusMessage {
  type: "lens";
  /** The board that is searched for; null before the start. */
  board: BoardMessage | null;
  look: LensLookMessage | null;
  /** How many pictures count. */
  taken: number;
  /** How many are needed. */
  least: number;
  /** Outline of the board in each picture that counts. */
  outlines: [number, number][][];
  /** Whether enough corners were seen in each part of the picture, row by row from the top. */
  parts: boolean[][];
  bars: LensBarsMessage;
  /** What to do next with the board, the most useful first; empty if nothing is missing. */
  next_steps: string[];
  /** Whether the calibration is being computed. */
  busy: boolean;
  /** Why the last request failed; empty if it did not. */
  problem: string;
  /** How many lenses were calibrated; ``/api/lens`` has the newest. */
  calibrations: number;
  /** The file that a save writes; null without a real robot. */
  profile: string | null;
  /** Whether the newest lens is in it. */
  saved: boolean;
}

/** Tape that the robot follows by its camera, without a map. */
export interface LineMessage {
  /** Speed where the tape is straight [m/s]; in bends it is slower. */
  speed?: number;
}

/** Rates and delays of the engine. */
export interface LoopMessage {
  step_hz: number;
  /** Work of one step, smoothed. */
  step_ms: number;
  frame_hz: number;
  /** From the exposure of the newest frame to this telemetry, on the robot's clock. */
  latency_ms: number;
}

/** The map that is drawn by driving, as far as it is drawn. */
export interface MapDrawingMessage {
  /** Its version, as in ``MappingMessage``; 0 without a map. */
  version: number;
  strokes: StrokeMessage[];
  /** The robot's path, corrected [m]. */
  path: [number, number][];
  /** Some of the points at which edges of tape were seen [m]. */
  edges: [number, number][];
  /** In a finished map, ends of strokes that no picture showed [m]. */
  unseen_ends: [number, number][];
  /** How well a finished map fits; empty before. */
  facts: string[];
  /** What is wrong with a finished map, or may be wrong. */
  remarks: string[];
  /** How many changes of a finished map can be taken back. */
  changes: number;
  /** Whether a finished map contradicts itself: it is saved only if that is asked for. */
  contradictory?: boolean;
}

/** The map that is drawn by driving, or the last one. */
export interface MappingMessage {
  /**
   * draw: it grows; finish: the whole map is adjusted; done: it can be saved; failed: there is
   * none.
   */
  state: "draw" | "finish" | "done" | "failed";
  /** How long the drive is [s]. */
  seconds: number;
  /** Whether adding pictures to the map is paused. */
  paused: boolean;
  /** How many drawings there were; ``/api/mapping`` has the newest. */
  version: number;
  /** The robot's pose in the new map; null before anything was drawn. */
  pose: PoseMessage | null;
  /** What is wrong or missing, or why it failed; null when all is well. */
  message: string | null;
}

/** Move an end of a stroke of the finished map, before it is saved. */
export interface MoveEndCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "move_end";
  /** Its number, from 0 on, in ``/api/mapping``. */
  stroke: number;
  /** Whether it is the end at the last point, or the one at the first. */
  last: boolean;
  x: number;
  /** Where to, in the new map [m]. */
  y: number;
  /** Version of that drawing. */
  version: number;
}

/**
 * Drive to goals, one after the other; along a closed curve, lap after lap; or along tape. It
 * holds until the robot is there, as long as its sender is connected and nobody else drives.
 */
export interface NavigateCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "navigate";
  /** Where to; null, without a curve or a line, only renews the journey that there is. */
  poses?: GoalMessage[] | null;
  /** The curve, in place of goals. */
  curve?: CurveMessage | null;
  /** Follow the nearest tape in sight to its end, in place of goals. */
  line?: LineMessage | null;
  /** Whether to begin again after the last goal. */
  repeat?: boolean;
  /** By name; null is that of the settings. */
  planner?: string | null;
  /** By name; null is that of the settings. */
  controller?: string | null;
  /** Whether the sender renews it itself, as ``drive``; the robot stands when that ends. */
  renewed?: boolean;
}

/** The journey to a goal, or the last one. */
export interface NavigationMessage {
  state: "planning" | "driving" | "waiting" | "arrived" | "canceled" | "failed";
  /** The way to the next goal that is left [m]. */
  remaining_m: number;
  /** How long it takes [s]. */
  remaining_s: number;
  /** Why the robot waits, was stopped or has failed; null when all is well. */
  reason: string | null;
  /** Of the goal that it drives to, from 0. */
  number: number;
  /** Where the robot shall be next. */
  target: PoseMessage | null;
  /** When the way was planned [s]; ``/api/navigation`` has it. */
  planned: number;
  /** Whether it is a closed curve, lap after lap; what is left is that of the lap. */
  on_curve?: boolean;
}

/** The way of a journey. */
export interface NavigationPathMessage {
  /** As in telemetry. */
  planned: number;
  goals: GoalMessage[];
  /** x, y [m] along the way to the next goal; empty before it is planned. */
  path: [number, number][];
}

/** Replay a recording in place of the robot, whose motors stop. */
export interface OpenRecordingCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "open_recording";
  /** Its name in ``/api/recordings``. */
  name: string;
}

/** One parameter of the filter, with its meaning. */
export interface ParameterMessage {
  name: string;
  group: "motion" | "sensor" | "filter" | "hypotheses" | "faults";
  value: number | string | boolean;
  default: number | string | boolean;
  meaning: string;
  unit: string;
  low: number | null;
  high: number | null;
  choices: string[];
  /** Whether only whole numbers are valid. */
  integer?: boolean;
  /** Whether the chosen filter and models use it. */
  used?: boolean;
}

/** The cloud of particles, and the hypotheses. */
export interface ParticlesMessage {
  count: number;
  /** Effective sample size, 1 to count. */
  effective: number;
  /** Where the robot may be, heaviest first; empty while nothing is known. */
  hypotheses: HypothesisMessage[];
  /**
   * How many of them may be the robot's place: 1 if one stands out, more if several look alike, 0
   * if none stands out.
   */
  alike: number;
  /** How many of them are likely enough to be drawn. */
  likely: number;
  /** xmin, ymin, xmax, ymax [m] of the area that x and y in ``cloud`` span. */
  extent: number[];
  /**
   * base64 of 8 bytes per particle, little-endian: uint16 x, uint16 y over the extent (0 to
   * 65535), int16 theta (pi is 32768), uint8 weight (255 is the heaviest), uint8 zero. At most
   * 2,000 particles.
   */
  cloud: string;
}

/** Stop updating the filter by measurements; odometry still moves the cloud. */
export interface PauseCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "pause";
}

/**
 * Stop adding pictures to the map that is drawn, or add them again. The wheels tell the robot's
 * way meanwhile.
 */
export interface PauseMapCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "pause_map";
  /** Null toggles. */
  paused?: boolean | null;
}

/**
 * Header of each binary message of ``/api/camera``. The message is the header's length in bytes
 * (uint32, little-endian), the header as JSON, and the picture as JPEG.
 */
export interface PictureMessage {
  type: "picture";
  /** Stamp of its exposure [s]. */
  stamp: number;
  /** What the scanner found in this picture; null if it was not scanned. */
  edges: EdgesMessage | null;
}

/** Do nothing; the stamp of the answer can be used to align clocks. */
export interface PingCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "ping";
}

/** Put the simulated robot elsewhere; the filter does not learn of it. */
export interface PlaceCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "place";
  x: number;
  y: number;
  theta: number;
}

/** How the scan fits a pose. */
export interface PoseFitMessage {
  x: number;
  y: number;
  theta: number;
  /** Log-likelihood of the whole scan, up to a constant. */
  log_likelihood: number;
  /**
   * Factor by which this scan multiplies a weight there, relative to the estimate's. The filter
   * takes the scan as worth less where hardly a particle would be left.
   */
  weight: number;
  /** Expected range of each ray there [m]; null where it meets no tape. */
  expected: (number | null)[];
  /**
   * Share of each ray in the log-likelihood, null if the ray does not count; null if computing the
   * shares takes too long.
   */
  shares: (number | null)[] | null;
  /** Log-likelihood minus the rays' shares; not zero only for models of one's own. */
  rest: number;
}

/** How the current scan fits a pose, and the estimate. */
export interface PoseFitsMessage {
  /** Stamp of the exposure of the scan's picture [s]. */
  stamp: number;
  /** The sensor model. */
  model: string;
  /** Share of the log-likelihood that counts in a weight. */
  power: number;
  /** Standard deviation [m] added (in squares) to the ranges', because the particles lie apart. */
  extra_sd: number;
  bearings: number[];
  /** Measured ranges [m]; null means no return. */
  ranges: (number | null)[];
  /** Where the rays start, in the robot frame. */
  robot_from_scan: PoseMessage;
  /** The pose that was asked for, or the particle nearest to the place. */
  asked: PoseFitMessage;
  /** That particle's weight, as a multiple of the mean; null if a pose was asked for. */
  particle: number | null;
  /** The estimate; null while there is none. */
  best: PoseFitMessage | null;
}

/** A pose in the map [m, m, rad]. */
export interface PoseMessage {
  x: number;
  y: number;
  theta: number;
}

/** One entry of the record of problems. */
export interface ProblemMessage {
  stamp: number;
  message: string;
}

/** The record of problems, newest last; at most the last hundred. */
export interface ProblemsMessage {
  problems: ProblemMessage[];
  /** The calls that led to the current fault of a user's own model, with their lines. */
  trace?: string;
}

/** What the scanner saw along one ray of the newest frame. */
export interface ProfileMessage {
  stamp: number;
  ray: number;
  bearing: number;
  /** Distance of each sample from the rays' centre, on the floor [m]. */
  distances: number[];
  /** Brightness, 0 to 255. */
  grey: number[];
  /** Response of the edge kernel, in grey levels; negative where it gets darker. */
  response: number[];
  threshold: number;
  /** Distance of the entry edge [m]. */
  entry: number | null;
  exit: number | null;
  /** Width measured across the line [m]. */
  width: number | null;
  counted: boolean;
  /** Why the ray counted or not, in plain words. */
  why: string;
}

/** Start a recording, or end the running one. */
export interface RecordCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "record";
  on: boolean;
}

/** One recording. */
export interface RecordingEntry {
  /** ``/api/recordings/NAME`` serves the file. */
  name: string;
  size_bytes: number;
  /** Null if it is unknown. */
  duration_s: number | null;
  /** Still being recorded, or cut off by a full disk or the end of the program; it can be read. */
  unfinished: boolean;
  /** When it was last written [s since 1970]. */
  changed: number;
  notes: string;
}

/** The running recording, or the last one. */
export interface RecordingMessage {
  /** Name of the recording; ``/api/recordings`` lists it. */
  file: string;
  running: boolean;
  duration_s: number;
  size_bytes: number;
  /** Why the recording ended by itself, or what is missing in it; null when all is well. */
  message: string | null;
}

/** Change how a recording is replayed; values that are left out stay as they are. */
export interface ReplayCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "replay";
  paused?: boolean | null;
  /** Seconds of the recording per second. */
  speed?: number | null;
  /** Go to this time since the recording's beginning. */
  position_s?: number | null;
  /** Go this many pictures forward (or back, if negative), and pause. */
  step?: number | null;
}

/** State of a replay. */
export interface ReplayMessage {
  file: string;
  /** Time since the recording's beginning. */
  position_s: number;
  duration_s: number;
  /** Seconds of the recording per second. */
  speed: number;
  paused: boolean;
  /** Progress of a seek to the requested time, 0 to 1; null when the replay is there. */
  catching_up: number | null;
  /** The recorded estimate. */
  estimate_then: PoseMessage | null;
  /** Whether ``close_recording`` goes back to a robot. */
  robot_waits?: boolean;
}

/** Restore the filter's configured parameters, and put the cloud at the start pose. */
export interface ResetCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "reset";
}

/** Update the filter again. */
export interface ResumeCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "resume";
}

/** The robot itself. */
export interface RobotMessage {
  name: string;
  connected: boolean;
  battery_v: number | null;
  can_be_placed: boolean;
  /** Name and version of the physics engine that moves a simulated robot; null: none does. */
  engine: string | null;
  /**
   * Faults of a simulated robot that it did not have at the start, by their names in
   * ``/api/faults``.
   */
  faults: Record<string, number | string>;
  /**
   * The robot's clock at the last calibration since the start [s]; ``/api/field`` changed then.
   * Null before the first.
   */
  calibrated: number | null;
}

/**
 * Drive a robot that explores to a pose: a turn on the spot, straight there, and another turn. The
 * exploration gives these by itself; a robot that does not explore stands.
 */
export interface RouteCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "route";
  x: number;
  y: number;
  /** In the frame of odometry. */
  theta: number;
  /** On the spot before all else, to the left [rad]; more than one turn is valid. */
  turn?: number;
}

/** Replay the last recording with the current parameters. */
export interface RunAgainCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "run_again";
}

/** How the error of a run differs from that of the run it is compared with. */
export interface RunDifferenceMessage {
  /** Root mean square error of the run less the other one's [m]. */
  rmse: number;
  low: number | null;
  /** Interval that holds the difference in 95 % [m]; null if a run is shorter than ten seconds. */
  high: number | null;
  /** Whether both saw the same pictures. */
  paired: boolean;
}

/** One run, over all of it or over its end. */
export interface RunMessage {
  number: number;
  /** Name of the recording that it replays; empty if the robot drove. */
  file: string;
  field: string;
  /** Whether its estimates are those that the recording has. */
  recorded: boolean;
  /** Whether it goes on. */
  present: boolean;
  kept: boolean;
  /** The filter's parameters that are not as they were at the start, by name. */
  parameters: Record<string, number | string | boolean>;
  /** The same ones as they were at the start. */
  standard: Record<string, number | string | boolean>;
  /** Their units, where they have any. */
  units: Record<string, string>;
  pictures: number;
  /** How long the pictures that count go on [s]. */
  seconds: number;
  /** Root mean square of the distances from the truth [m]; null without an estimate. */
  rmse: number | null;
  /** [m] */
  median: number | null;
  /** [m] */
  worst: number | null;
  /** Share of the pictures at which the estimate is not within 50 mm and 10 degrees. */
  lost: number;
  /**
   * Share of the pictures at which it says certain and the truth lies outside its bounds; null
   * where that is not recorded.
   */
  misleading: number | null;
  /** From the beginning until it is right for a second [s]; null if it never is. */
  time_to_right: number | null;
  /** From the run that all are compared with; null for that run itself. */
  difference: RunDifferenceMessage | null;
}

/** The runs that are listed, the newest first. */
export interface RunsMessage {
  /** Number of the run that all are compared with. */
  against: number | null;
  runs: RunMessage[];
}

/**
 * Save the map under a new name; the dashboard's maps have a folder. While it is drawn, it is
 * saved as it is, and drawn on.
 */
export interface SaveMapCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "save_map";
  name: string;
  /**
   * Whether to go on in the new map at once, if it is finished. The robot stands meanwhile, and a
   * recording ends.
   */
  use?: boolean;
  /** Whether a map is saved that contradicts itself. */
  force?: boolean;
}

/** The newest scan; ``PictureMessage`` has its edges in the picture. */
export interface ScanMessage {
  /** Stamp of its picture's exposure [s]. */
  stamp: number;
  bearings: number[];
  /** Ranges [m]; null means no return. */
  ranges: (number | null)[];
  /** Where the rays start, in the robot frame. */
  robot_from_scan: PoseMessage;
  /** The estimate at the scan's stamp, to draw the scan from. */
  robot: PoseMessage | null;
  /** Median width measured over the rays that counted [m]. */
  tape_width: number | null;
}

/** Spread the cloud over the whole field: the robot may be anywhere. */
export interface ScatterCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "scatter";
}

/**
 * Change what is known of the robot: how it differs from its description. Values that are left out
 * stay as they are.
 */
export interface SetCalibrationCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "set_calibration";
  /** Differences by name, in the units of the profile's file [rad, m, s, relative]. */
  values: Record<string, number>;
  /** Their standard deviations; a value without one is as uncertain as in a robot built by hand. */
  sd?: Record<string, number>;
  /** When it was measured; null means when the other values were. */
  made?: string | null;
  /** What it was measured by. */
  source?: string;
  /** How well it fits (``[fit]`` of a profile); null leaves what was said of the other values. */
  fit?: Record<string, boolean | number | string[]> | null;
}

/** Change what is wrong with the simulated robot and its camera, while it drives on. */
export interface SetFaultsCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "set_faults";
  /** Values by name; ``/api/faults`` lists the names. */
  values: Record<string, number | string>;
}

/** Change parameters of the filter: all or none; ``/api/parameters`` lists their names. */
export interface SetParametersCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "set_parameters";
  values: Record<string, number | string | boolean>;
}

/** Start the filter from given poses: the robot is at or near one of them. */
export interface SetParticlesCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "set_particles";
  /** x, y, theta of each pose. */
  poses: [number, number, number][];
  /** How likely each pose is, on any scale; null is equally likely. */
  weights?: number[] | null;
}

/** Tell the filter where the robot is, and how sure that is. */
export interface SetPoseCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "set_pose";
  x: number;
  y: number;
  theta: number;
  sd_xy?: number | null;
  sd_theta?: number | null;
  /**
   * 9 numbers by rows [m^2, m rad, rad^2], symmetric and positive semi-definite, instead of the
   * standard deviations.
   */
  covariance?: number[] | null;
}

/**
 * Say what the robot must not touch on its way to goals, besides shapes on the floor. It holds
 * until the field is loaded again.
 */
export interface SetWallsCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "set_walls";
  /** Whether the robot may cross tape; null leaves that as it is. */
  tape?: "wall" | "ignored" | null;
  /** All keep-out zones: each by its corners; an empty list removes them, null leaves them. */
  zones?: [number, number][][] | null;
}

/** Switch a layer of the 3D view on or off; all viewers share that view. */
export interface ShowCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "show";
  layer: "particles" | "headings" | "rays" | "covariance" | "paths" | "truth" | "camera";
  visible: boolean;
}

/** Start to draw a map of the floor, however the robot is driven. */
export interface StartMapCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "start_map";
  /** Whether to forget an unsaved map; otherwise the command is refused if there is one. */
  discard?: boolean;
  /** Whether to begin paused: no pictures are added until ``pause_map`` resumes. */
  paused?: boolean;
}

/** How far the estimate can be relied on. */
export type State = "certain" | "given" | "approximate" | "ambiguous" | "searching" | "lost";

/** Stop at once, whoever drives. */
export interface StopCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "stop";
}

/** The centre line of a piece of tape. */
export interface StrokeMessage {
  /** Points along it [m]; a closed line repeats its first point. */
  points: [number, number][];
  /** Half of the 95 % interval across the line, where it is least certain [m]. */
  interval: number;
}

/** Take over from the client that drives, and end a stop that holds. */
export interface TakeCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "take";
}

/** Start the filter where a robot that has looked around must be; a journey says so itself. */
export interface TakePlaceCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "take_place";
  x: number;
  y: number;
  theta: number;
  /** By rows [m^2, m rad, rad^2], symmetric and positive semi-definite. */
  covariance: number[];
}

/** Everything that one tick shows. */
export interface TelemetryMessage {
  type: "telemetry";
  /** The robot's clock [s]. */
  stamp: number;
  map: string;
  truth: PoseMessage | null;
  /** Dead reckoning since the start (or the last ``place`` command), in the map. */
  odometry: PoseMessage | null;
  estimate: EstimateMessage | null;
  integrity: IntegrityMessage;
  twist: TwistMessage;
  /** Measured speeds of the left and the right wheel [rad/s]. */
  wheels?: number[] | null;
  /** ``idle``, ``drive``, ``figure_eight``, ``calibrate``, ``explore``, or a feature's own. */
  mode: string;
  driver: DriverMessage;
  particles: ParticlesMessage;
  scan: ScanMessage;
  robot: RobotMessage;
  loop: LoopMessage;
  filter: FilterMessage;
  /** What is wrong now, in plain words; empty when all is well. */
  problems: string[];
  /** Problems since the start; ``/api/problems`` lists them. */
  error_count: number;
  recording?: RecordingMessage | null;
  /** Null before the first drive of a calibration. */
  calibration?: CalibrationDriveMessage | null;
  /** Null while no map is drawn. */
  mapping?: MappingMessage | null;
  /** Null before the first goal. */
  navigation?: NavigationMessage | null;
  /** When it was last said what the robot does not touch; ``/api/navigation/walls`` has it. */
  walls?: number | null;
  /** Edges (k, 4) of tape that does not lie where it is drawn: there [m]; null if all does. */
  misplaced_tape?: [number, number, number, number][] | null;
  /** Null if this is not a replay. */
  replay?: ReplayMessage | null;
  /** Further values, by name; absent without any. */
  values?: Record<string, boolean | number | string | null> | null;
  /** Layers of the 3D view that are switched off for all viewers; null if there is no 3D view. */
  hidden_layers?: ("particles" | "headings" | "rays" | "covariance" | "paths" | "truth" | "camera")[] | null;
}

/** A velocity [m/s, rad/s], as applied after limits. */
export interface TwistMessage {
  v: number;
  omega: number;
}

/** Go back to the calibration before the last one by driving; a second undo takes that back. */
export interface UndoCalibrationCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "undo_calibration";
}

/** Take back the last set_pose, set_particles or scatter: restore what was believed before. */
export interface UndoCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "undo";
}

/** Take back the last change of the finished map, before it is saved. */
export interface UndoEditCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "undo_edit";
  /** Of that drawing. */
  version: number;
}

/** One number of the robot that is measured, in a unit for people. */
export interface UnknownMessage {
  name: string;
  unit: string;
  /** Difference from the description. */
  value: number;
  /** Half of the 95 % interval around the value [same unit]. */
  interval: number;
  /** The same for a robot that was built by hand and not calibrated. */
  prior: number;
  /** Whether the drive determined it. */
  learnt: boolean;
}

/** Update once with the next frame, even if the filter is paused or the robot stands still. */
export interface UpdateCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "update";
}

/**
 * Switch to another field: a simulated robot is put there; a real one has to be. The robot stands
 * meanwhile, and a running recording ends.
 */
export interface UseFieldCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  /**
   * The robot's clock when it was sent [s], as answers tell it. A drive command that has come half
   * a second late or more is refused, if it says so: somebody may have stopped the robot.
   */
  sent?: number | null;
  type: "use_field";
  /** One of ``/api/fields``, or generated- and a number. */
  name: string;
}

/** The camera of a page's 3D view, in the map. */
export interface ViewCameraMessage {
  position: [number, number, number];
  /** How it is turned: its x points right, its y down, and its z ahead. */
  wxyz: [number, number, number, number];
  /** The angle that it sees from top to bottom [rad]. */
  fov: number;
}

/** What the robot does not touch on its way to goals, besides shapes on the floor. */
export interface WallsMessage {
  /** Whether it may cross tape. */
  tape: "wall" | "ignored";
  /** Keep-out zones: x, y [m] of their corners. */
  zones: number[][][];
}
