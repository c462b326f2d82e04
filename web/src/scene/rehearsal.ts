/** A rehearsal's path and what would have been said of it, for a drawing and for words. Pure. */

import { msg, str } from "@lit/localize";
import type { RehearsalVerdict, TwinUpdate } from "../generated/wire.js";
import type { FloorPose } from "./pose-command.js";

/** One stretch of the path that is driven alike. */
export interface PathStretch {
  readonly points: readonly { readonly x: number; readonly y: number }[];
  /** Why the robot would have been refused; empty: it would not. */
  readonly why: string;
  readonly share: number;
}

/** What the drawing shows of the floor (m). */
export interface FloorBox {
  readonly x: number;
  readonly y: number;
  readonly size: number;
}

const LEAST_BOX_M = 1;
const MARGIN = 0.15;

export function pathPoses(path: readonly number[], frame: string): readonly FloorPose[] {
  const poses: FloorPose[] = [];
  for (let at = 0; at + 2 < path.length; at += 3) poses.push({ frame, x: path[at] ?? 0, y: path[at + 1] ?? 0, yaw: path[at + 2] ?? 0 });
  return poses;
}

/** The path in stretches; neighbours share the pose between them, so that the line has no holes. */
export function pathStretches(poses: readonly FloorPose[], verdicts: readonly RehearsalVerdict[]): readonly PathStretch[] {
  const marks = [{ at: 0, why: "", share: 1 }, ...verdicts];
  return marks.flatMap(({ at, why, share }, number) => {
    const end = marks[number + 1]?.at ?? poses.length - 1;
    const points = poses.slice(at, end + 1).map(({ x, y }) => ({ x, y }));
    return points.length < 2 ? [] : [{ points, why, share }];
  });
}

/** A square around all poses, with some room. */
export function pathBox(poses: readonly FloorPose[]): FloorBox {
  if (poses.length === 0) return { x: -LEAST_BOX_M / 2, y: -LEAST_BOX_M / 2, size: LEAST_BOX_M };
  const xs = poses.map(({ x }) => x);
  const ys = poses.map(({ y }) => y);
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const size = Math.max(LEAST_BOX_M, right - left, high - low) * (1 + 2 * MARGIN);
  return { x: (left + right - size) / 2, y: (low + high - size) / 2, size };
}

/** What would have been said, in words; one line for each reason. */
export function verdictLines({ verdicts }: Pick<TwinUpdate, "verdicts">): readonly string[] {
  const said = verdicts.flatMap(({ why, share }) => {
    if (why !== "") return [msg(str`Driving would have been refused: ${why}`)];
    return share < 1 ? [msg(str`Speed would have been cut to ${Math.round(share * 100).toString()} %`)] : [];
  });
  return [...new Set(said)];
}
