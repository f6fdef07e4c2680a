// Made from app/messages/ by `python -m app.messages.typescript`; change it there.

export type Command =
  | DriveCommand
  | FigureEightCommand
  | PauseCommand
  | PingCommand
  | PlaceCommand
  | RecordCommand
  | ReplayCommand
  | ResetCommand
  | ResumeCommand
  | ScatterCommand
  | SetParametersCommand
  | SetParticlesCommand
  | SetPoseCommand
  | ShowCommand
  | StopCommand
  | UpdateCommand;

/** The command was taken. */
export interface AckMessage {
  type: "ack";
  id: number | string | null;
  /** The robot's clock when the answer was written, to line up the clocks [s]. */
  stamp: number | null;
}

/** Drive; holds for 0.5 s, so it is renewed. Beyond the limits it is limited. */
export interface DriveCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "drive";
  v: number;
  omega: number;
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

/** The field and the robot on it: what a map view needs once. */
export interface FieldMessage {
  name: string;
  /** xmin, ymin, xmax, ymax [m] of ``/api/field.png``. */
  extent: number[];
  start: PoseMessage;
  /** The robot's outline on the floor [m], in the robot frame. */
  robot_outline: [number, number][];
  max_v: number;
  max_omega: number;
  image_width: number;
  /** Size of the camera's picture [px]. */
  image_height: number;
  /** Width of tape that the scanner looks for [m], to compare with ``ScanMessage.tape_width``. */
  tape_width: number;
  /** Each ray as a line of pixels, from its start to its end in the picture. */
  rays_px: [number, number][][];
}

/** Drive the open-loop figure-eight; holds for 0.5 s like drive, and goes on when renewed. */
export interface FigureEightCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "figure_eight";
}

/** What the filter does. */
export interface FilterMessage {
  paused: boolean;
  /** Measurement updates since the last set_pose, scatter or reset. */
  updates: number;
  /**
   * What is wrong with a model in a file of the user's own, with file and line; the robot stands
   * still and the filter pauses until it is mended.
   */
  broken: string | null;
}

/** Whether the program does its job. */
export interface HealthMessage {
  status: "ok" | "degraded" | "failed";
  detail: string;
  robot: string;
  uptime_s: number;
  step_hz: number;
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

/** What is claimed of the estimate. */
export interface IntegrityMessage {
  /**
   * certain: one place within a narrow bound; approximate: one, within a wide bound; ambiguous:
   * several places look alike; searching: no place stands out; lost: one did that fits no more.
   */
  state: State;
  /**
   * The robot is within this distance of the estimate [m], in 99.9 % of pictures; null where
   * nothing is claimed.
   */
  radius: number | null;
  /** Its heading is within this angle of the estimate's [rad]; null where nothing is claimed. */
  heading_bound: number | null;
  /** Reasons for doubt in plain words, the likeliest first; empty when there is none. */
  alerts: string[];
}

/** How the engine keeps up. */
export interface LoopMessage {
  step_hz: number;
  /** Work of one step, smoothed. */
  step_ms: number;
  frame_hz: number;
  /** From the exposure of the newest frame to this telemetry, on the robot's clock. */
  latency_ms: number;
}

/** One parameter of the filter, with its meaning. */
export interface ParameterMessage {
  name: string;
  group: "motion" | "sensor" | "filter" | "hypotheses";
  value: number | string | boolean;
  default: number | string | boolean;
  meaning: string;
  unit: string;
  low: number | null;
  high: number | null;
  choices: string[];
  /** Whether only whole numbers are valid. */
  integer?: boolean;
}

/** The cloud. */
export interface ParticlesMessage {
  count: number;
  /** Effective sample size, 1 to count. */
  effective: number;
  /** Where the robot may be, heaviest first; none while nothing can be said. */
  hypotheses: HypothesisMessage[];
  /** xmin, ymin, xmax, ymax [m] that the bytes of ``cloud`` span. */
  extent: number[];
  /**
   * base64 of 8 bytes a particle, little-endian: uint16 x, uint16 y over the extent (0 to 65535),
   * int16 theta (pi is 32768), uint8 weight (255 is the heaviest), uint8 zero. At most 2,000.
   */
  cloud: string;
}

/** Stop updating the filter by measurements; odometry goes on moving the cloud. */
export interface PauseCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "pause";
}

/** Do nothing; the answer's stamp lines up the clocks. */
export interface PingCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "ping";
}

/** Put the simulated robot itself elsewhere; the filter is not told. */
export interface PlaceCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "place";
  x: number;
  y: number;
  theta: number;
}

/** A pose in the map [m, m, rad]. */
export interface PoseMessage {
  x: number;
  y: number;
  theta: number;
}

/** One entry of the record of errors. */
export interface ProblemMessage {
  stamp: number;
  message: string;
}

/** The record of errors, newest last; at most the last hundred. */
export interface ProblemsMessage {
  problems: ProblemMessage[];
}

/** What the scanner saw along one ray of the newest frame. */
export interface ProfileMessage {
  stamp: number;
  ray: number;
  bearing: number;
  /** Floor distance of each sample from the rays' centre [m]. */
  distances: number[];
  /** Brightness, 0 to 255. */
  grey: number[];
  /** Answer of the edge kernel, in grey levels; negative where it gets darker. */
  response: number[];
  threshold: number;
  /** Distance of the entry edge [m]. */
  entry: number | null;
  exit: number | null;
  /** Measured across the line [m]. */
  width: number | null;
  counted: boolean;
  /** Why it counted or not, in plain words. */
  why: string;
}

/** Begin a recording, or end the one that runs. */
export interface RecordCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "record";
  on: boolean;
}

/** What is being recorded, or was until it ended by itself. */
export interface RecordingMessage {
  /** Its name; ``/api/recordings`` has it. */
  file: string;
  running: boolean;
  duration_s: number;
  size_bytes: number;
  /** Why it ended by itself, or what is missing in it; null when all is well. */
  message: string | null;
}

/** Change how a recording is replayed; what is left out stays. */
export interface ReplayCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "replay";
  paused?: boolean | null;
  /** Seconds of the recording a second. */
  speed?: number | null;
  /** Go to a time since the beginning of the recording. */
  position_s?: number | null;
  /** Go so many pictures on, or back, and pause. */
  step?: number | null;
}

/** Where in a recording the program is. */
export interface ReplayMessage {
  file: string;
  /** Since its beginning. */
  position_s: number;
  duration_s: number;
  /** Seconds of the recording a second. */
  speed: number;
  paused: boolean;
  /** How far it is on its way to a place that was asked for, 0 to 1; null when it is there. */
  catching_up: number | null;
  /** What was estimated when it was recorded. */
  estimate_then: PoseMessage | null;
}

/** The filter's parameters as configured at the start, and the cloud at the start pose. */
export interface ResetCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "reset";
}

/** Update the filter again. */
export interface ResumeCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "resume";
}

/** The robot itself. */
export interface RobotMessage {
  name: string;
  connected: boolean;
  battery_v: number | null;
  can_be_placed: boolean;
}

/** The newest scan, and where it was found in the picture. */
export interface ScanMessage {
  /** Exposure of the frame it comes from [s]. */
  stamp: number;
  bearings: number[];
  /** [m]; no return is null. */
  ranges: (number | null)[];
  /** Where the rays start, in the robot frame. */
  robot_from_scan: PoseMessage;
  /** The estimate at the scan's stamp, to draw the scan from. */
  robot: PoseMessage | null;
  /** Pixel (u, v) where the ray enters the tape, a ray each; null where none counted. */
  entry_px: ([number, number] | null)[];
  exit_px: ([number, number] | null)[];
  /** Median width measured over the rays that counted [m]. */
  tape_width: number | null;
}

/** Spread the cloud over the whole field: the robot may be anywhere. */
export interface ScatterCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "scatter";
}

/** Change parameters of the filter; all or none, names as ``/api/parameters`` lists them. */
export interface SetParametersCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "set_parameters";
  values: Record<string, number | string | boolean>;
}

/** Start the filter from given poses: the robot is at one of them, or near. */
export interface SetParticlesCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "set_particles";
  /** x, y, theta of each. */
  poses: [number, number, number][];
  /** How likely each is, in any measure; all alike without. */
  weights?: number[] | null;
}

/** Tell the filter where the robot is, and how sure that is. */
export interface SetPoseCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
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

/** Switch a layer of the 3D view on or off; all viewers share that view. */
export interface ShowCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "show";
  layer: "particles" | "headings" | "rays" | "covariance" | "paths" | "truth";
  visible: boolean;
}

/** How far the answer may be relied on. */
export type State = "certain" | "approximate" | "ambiguous" | "searching" | "lost";

/** Stand still at once, whatever drives. */
export interface StopCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "stop";
}

/** Everything that one tick shows. */
export interface TelemetryMessage {
  type: "telemetry";
  /** The robot's clock [s]. */
  stamp: number;
  map: string;
  truth: PoseMessage | null;
  /** Dead reckoning since the start (or the last place), in the map. */
  odometry: PoseMessage | null;
  estimate: EstimateMessage | null;
  integrity: IntegrityMessage;
  twist: TwistMessage;
  mode: "idle" | "drive" | "figure_eight";
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
  /** Null with a robot that is there now. */
  replay?: ReplayMessage | null;
  /** Layers of the 3D view that are switched off, for all viewers; null where there is none. */
  hidden_layers?: ("particles" | "headings" | "rays" | "covariance" | "paths" | "truth")[] | null;
}

/** A velocity [m/s, rad/s], as applied after limits. */
export interface TwistMessage {
  v: number;
  omega: number;
}

/** One measurement update with the next frame, even paused or standing still. */
export interface UpdateCommand {
  /** Repeated in the answer. */
  id?: number | string | null;
  type: "update";
}
