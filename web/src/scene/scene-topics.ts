/** Which raw topics a scene shows: by the type of their messages. Pure. */

import { msg } from "@lit/localize";

export type LayerKind = "scan" | "cloud" | "grid" | "path" | "odometry" | "poses" | "pose" | "marker" | "markers" | "camera";
/** What is not drawn itself, and says where things are and what the robot looks like. */
export type BasisKind = "transforms" | "joints" | "robot" | "grid update";

export interface SceneKind {
  readonly kind: LayerKind | BasisKind;
  /** Messages a second at the most. */
  readonly rate: number;
  /** What it is called on the page. */
  readonly name: string;
}

/** The one table; a new kind of layer takes a row here and its drawing. */
const KINDS: Readonly<Record<string, SceneKind>> = {
  "tf2_msgs/msg/TFMessage": { kind: "transforms", rate: 100, name: msg("Transforms") },
  "sensor_msgs/msg/JointState": { kind: "joints", rate: 25, name: msg("Joints") },
  "sensor_msgs/msg/LaserScan": { kind: "scan", rate: 20, name: msg("Laser scan") },
  "sensor_msgs/msg/PointCloud2": { kind: "cloud", rate: 10, name: msg("Point cloud") },
  "nav_msgs/msg/OccupancyGrid": { kind: "grid", rate: 2, name: msg("Map") },
  "map_msgs/msg/OccupancyGridUpdate": { kind: "grid update", rate: 5, name: msg("Map's updates") },
  "nav_msgs/msg/Path": { kind: "path", rate: 5, name: msg("Path") },
  "nav_msgs/msg/Odometry": { kind: "odometry", rate: 25, name: msg("Odometry") },
  "geometry_msgs/msg/PoseArray": { kind: "poses", rate: 5, name: msg("Poses") },
  "geometry_msgs/msg/PoseStamped": { kind: "pose", rate: 10, name: msg("Pose") },
  "geometry_msgs/msg/PoseWithCovarianceStamped": { kind: "pose", rate: 10, name: msg("Pose") },
  // It hardly ever changes: the pictures come by themselves.
  "sensor_msgs/msg/CameraInfo": { kind: "camera", rate: 2, name: msg("Camera") },
  "visualization_msgs/msg/Marker": { kind: "marker", rate: 20, name: msg("Marker") },
  "visualization_msgs/msg/MarkerArray": { kind: "markers", rate: 20, name: msg("Markers") },
};
const ROBOT: SceneKind = { kind: "robot", rate: 1, name: msg("Robot model") };
const BASIS: readonly string[] = ["transforms", "joints", "grid update"];
/** Costmaps cover the map; clouds and markers may be many, and pictures cost the line: a person switches them on. */
const OFF_AT_FIRST: readonly string[] = ["cloud", "markers", "marker", "poses", "camera"];

/** The kind of a topic; null of one that a scene does not show. */
export function sceneKind(topic: string, type: string): SceneKind | null {
  if (type === "std_msgs/msg/String") return topic.endsWith("robot_description") ? ROBOT : null;
  return KINDS[type] ?? null;
}

/** Whether it can be switched on and off; the rest is heard as long as the scene is looked at. */
export function isSwitched({ kind }: SceneKind): boolean {
  return !BASIS.includes(kind);
}

/** Whether it is shown before anybody chose. */
export function isShownAtFirst(topic: string, { kind }: SceneKind): boolean {
  return !OFF_AT_FIRST.includes(kind) && !topic.includes("costmap");
}

/** The frame that stands still, by REP-105: the map's where there is one, else where odometry began. */
export function chooseFixedFrame(has: (name: string) => boolean, roots: readonly string[]): string {
  return ["map", "odom", "world", "earth"].find(has) ?? roots[0] ?? "";
}

/** Frames of digital twins: the body of a robot under a name of its own, `twin/base_link` (REP-105 with a prefix). */
export function ghostFrames(names: readonly string[]): readonly string[] {
  return names.filter((name) => /^[^/]+\/base_link$/.test(name));
}

/** The robot's own frame, which a camera follows. */
export function chooseRobotFrame(has: (name: string) => boolean, modelRoot: string): string {
  return ["base_footprint", "base_link"].find(has) ?? modelRoot;
}
