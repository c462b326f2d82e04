/** The robot's form once more, translucent, where a digital twin is: at each frame that ends as the robot's own does. */

import { Group, Mesh, MeshBasicMaterial, type Scene } from "three";
import type { FrameTree } from "../../scene/frame-tree.js";
import type { SceneModel } from "../../scene/scene-model.js";
import { composed, IDENTITY } from "../../scene/transform.js";
import { ghostFrames } from "../../scene/scene-topics.js";
import type { SceneColours, SceneOptions } from "./drawing.js";
import type { RobotModel } from "./robot-model.js";

const OPACITY = 0.35;
/** The robot's frame that a twin's frame is the same of. */
const BODY = "base_link";
const NONE: readonly string[] = [];

export class GhostModels {
  private readonly ghosts = new Map<string, Group>();
  private readonly paint = new MeshBasicMaterial({ transparent: true, opacity: OPACITY, depthWrite: false });
  private meshes = 0;
  private robot: RobotModel | null = null;
  private tree: FrameTree | null = null;
  private version = -1;
  private frames: readonly string[] = NONE;

  constructor(private readonly scene: Scene) {}

  setColours({ accent, night }: SceneColours): void {
    this.paint.color.set(night ? "#ff0000" : accent);
  }

  /** Draws all that there are now; none without a robot's form. */
  update(robot: RobotModel | null, model: SceneModel, { fixed, showRobot }: SceneOptions): void {
    const frames = robot === null || !showRobot ? NONE : this.framesOf(model);
    if (frames.length === 0 && this.ghosts.size === 0) return;
    // Meshes come one by one: a ghost of fewer is made anew.
    const meshes = robot === null ? 0 : countMeshes(robot);
    if (meshes !== this.meshes || robot !== this.robot) this.clear();
    [this.meshes, this.robot] = [meshes, robot];
    for (const [frame, ghost] of this.ghosts) {
      if (frames.includes(frame)) continue;
      this.scene.remove(ghost);
      this.ghosts.delete(frame);
    }
    if (robot === null) return;
    // From the body to the link that all others hang on: a footprint, as a rule.
    const root = model.tree.find(BODY, robot.frame, Infinity) ?? IDENTITY;
    for (const frame of frames) {
      const ghost = this.ghosts.get(frame) ?? this.add(frame, robot);
      const place = model.tree.find(fixed, frame, Infinity);
      ghost.visible = place !== null;
      if (place === null) continue;
      const { at, turn } = composed(place, root);
      ghost.position.set(...at);
      ghost.quaternion.set(...turn);
    }
  }

  /** Names of frames are the same for most pictures. */
  private framesOf({ tree }: SceneModel): readonly string[] {
    if (tree !== this.tree || tree.version !== this.version) [this.tree, this.version, this.frames] = [tree, tree.version, ghostFrames(tree.names())];
    return this.frames;
  }

  dispose(): void {
    this.clear();
    this.paint.dispose();
  }

  private clear(): void {
    // Their shapes are the robot's, who disposes of them.
    for (const ghost of this.ghosts.values()) this.scene.remove(ghost);
    this.ghosts.clear();
  }

  private add(frame: string, robot: RobotModel): Group {
    const ghost = new Group();
    robot.root.updateWorldMatrix(true, true);
    const inverse = robot.root.matrixWorld.clone().invert();
    robot.root.traverse((part) => {
      if (!(part instanceof Mesh)) return;
      const shape = new Mesh(part.geometry, this.paint);
      shape.matrixAutoUpdate = false;
      shape.matrix.multiplyMatrices(inverse, part.matrixWorld);
      ghost.add(shape);
    });
    this.ghosts.set(frame, ghost);
    this.scene.add(ghost);
    return ghost;
  }
}

function countMeshes(robot: RobotModel): number {
  let count = 0;
  robot.root.traverse((part) => {
    if (part instanceof Mesh) count += 1;
  });
  return count;
}
