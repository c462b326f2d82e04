/** The robot as its description draws it, with its links where the frames say. */

import type { Object3D } from "three";
import URDFLoader, { type URDFJoint, type URDFRobot } from "urdf-loader";
import type { JointState } from "../../scene/messages.js";
import { whyNoModel } from "../../scene/robot-description.js";
import type { SceneModel } from "../../scene/scene-model.js";
import type { MeshStore } from "./meshes.js";

export class RobotModel {
  readonly root: URDFRobot;
  /** Frame of the link that all others hang on. */
  readonly frame: string;
  private readonly jointed: readonly JointedLinks[];

  /**
   * @param onChange a mesh has come
   * @param onTrouble a mesh cannot be had; a sentence
   * @throws Error when the text is no robot description
   */
  constructor(urdf: string, meshes: MeshStore, listener: { readonly onChange: () => void; readonly onTrouble: (why: string) => void }) {
    const why = whyNoModel(urdf);
    if (why !== null) throw new Error(why);
    // Pictures that links are painted with come from where meshes come from.
    const loader = new URDFLoader(meshes.pictures);
    loader.packages = (name) => `package://${name}`;
    loader.loadMeshCb = (uri, _manager, done) => {
      meshes.load(uri).then(
        (mesh) => {
          done(mesh);
          listener.onChange();
        },
        (error: unknown) => {
          listener.onTrouble(error instanceof Error ? error.message : String(error));
        },
      );
    };
    this.root = loader.parse(urdf);
    this.jointed = Object.values(this.root.joints).flatMap((joint) => linksOf(joint) ?? []);
    // A link without a joint above it: its frame is the robot's.
    const children = new Set(this.jointed.map(({ child }) => child));
    this.frame = Object.keys(this.root.links).find((name) => !children.has(name)) ?? "";
  }

  /** What the joints say of frames, for whoever has no transforms of them. */
  addFrames(model: SceneModel, joints: JointState | null, nowMs: number): void {
    joints?.names.forEach((name, at) => {
      const value = joints.positions[at];
      if (value !== undefined && Number.isFinite(value)) this.root.setJointValue(name, value);
    });
    for (const { joint, parent, child } of this.jointed) {
      const fixed = joint.jointType === "fixed";
      if (!fixed && joints === null) continue;
      const { position, quaternion } = joint;
      model.tree.add(
        {
          parent,
          child,
          timeUs: joints?.timeUs ?? 0,
          transform: { at: [position.x, position.y, position.z], turn: [quaternion.x, quaternion.y, quaternion.z, quaternion.w] },
          source: "joints",
          fixed,
        },
        nowMs,
      );
    }
  }

  /** Puts each link where the tree has it now. */
  placeLinks(model: SceneModel): void {
    for (const { joint, parent, child } of this.jointed) {
      const found = model.tree.find(parent, child, Infinity);
      if (found === null) continue;
      joint.position.set(...found.at);
      joint.quaternion.set(...found.turn);
    }
  }
}

/** A joint with the names of the links that it joins. */
interface JointedLinks {
  readonly joint: URDFJoint;
  readonly parent: string;
  readonly child: string;
}

function linksOf(joint: URDFJoint): JointedLinks | null {
  const child = joint.children.find((part) => "isURDFLink" in part);
  return child === undefined || joint.parent === null ? null : { joint, parent: linkName(joint.parent), child: linkName(child) };
}

/** The robot itself stands for its root link, and has its own name besides. */
function linkName(link: Object3D): string {
  return (link as Object3D & { readonly urdfName?: string }).urdfName ?? link.name;
}
