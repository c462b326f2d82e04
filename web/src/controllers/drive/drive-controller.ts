/** Seat, STOP and hands of one device, built and taken apart together. */

import type { HeldStopUpdate, LeaseUpdate, StopUpdate } from "../../generated/wire.js";
import type { DeviceShape, DriveShape } from "../../generated/api.js";
import { DriveInputs } from "./drive-inputs.js";
import { HapticCues, playCue } from "./haptics.js";
import type { DriveLimits } from "./drive-machine.js";
import { DriveSession, type DriveConnection, type FrameMessage } from "./drive-session.js";
import { StopClient } from "./stop-client.js";

/** Below this the gateway lets the vehicle go slower than it is asked. */
const FULL_CAP = 0.995;

/** What was said of a device before this page was opened. */
export interface KnownState {
  readonly lease: LeaseUpdate | undefined;
  readonly stop: StopUpdate | undefined;
  readonly heldStop: HeldStopUpdate | undefined;
}

export class DriveController {
  readonly stop: StopClient;
  /** Null for someone who may not drive this device. */
  readonly seat: DriveSession | null;
  private readonly hands: DriveInputs;
  private readonly cues = new HapticCues();
  private stops: (() => void)[] = [];

  /** @param messageOf - how its frames are said; without it they are the robot's */
  constructor(line: DriveConnection, site: string, device: DeviceShape, online: boolean, messageOf?: FrameMessage) {
    const { drive } = device;
    this.stop = new StopClient(line, site, device.id, online);
    const limits = drive && limitsOf(drive);
    const may = device.rights.includes("use");
    this.seat = limits && may ? new DriveSession(line, { site, device: device.id, limits }, online, undefined, messageOf) : null;
    this.hands = new DriveInputs(this.seat, this.stop);
  }

  openAll(known: KnownState): void {
    // STOP bars the seat in the same turn as it is pressed: zeros follow it down the line.
    const barSeat = this.stop.subscribe(() => {
      if (!this.seat) return;
      if (this.stop.desk.blocksDriving) this.seat.block("stop");
      else if (this.seat.machine.isBlocked("stop")) this.seat.unblock("stop");
    });
    const seatCues = this.seat?.subscribe(this.playNews) ?? null;
    this.stops = [barSeat, this.stop.subscribe(this.playNews), ...(seatCues === null ? [] : [seatCues])];
    this.stop.open(known.stop, known.heldStop);
    this.seat?.open(known.lease);
    this.hands.open();
  }

  closeAll(): void {
    this.hands.close();
    this.seat?.close();
    this.stop.close();
    for (const stop of this.stops) stop();
    this.stops = [];
  }

  /** Whoever has the robot in the hand feels what stands in its way. */
  private readonly playNews = (): void => {
    const { seat } = this;
    const mine = seat?.lease.state.kind === "mine";
    const cue = this.cues.nextCue(
      {
        stopped: this.stop.desk.blocksDriving,
        locked: mine && seat.machine.isBlocked("interlock"),
        limited: mine && seat.machine.phase === "driving" && seat.told !== null && (seat.told.cap < FULL_CAP || seat.told.why !== ""),
      },
      performance.now(),
    );
    if (cue !== null) playCue(cue, navigator);
  };
}

function limitsOf(drive: DriveShape): DriveLimits {
  return {
    maxSpeed: drive.max_speed,
    maxReverse: drive.max_reverse,
    maxTurn: drive.max_turn,
    ...(drive.max_sideways > 0 ? { maxSideways: drive.max_sideways } : {}),
    ...(drive.max_steering > 0 ? { maxSteering: drive.max_steering } : {}),
    ...(drive.ptz ? { aims: drive.joints.map(({ id }) => id) } : {}),
    ...(drive.joints.length > 0 ? { jointSpeeds: drive.joints.map(({ max_speed }) => max_speed) } : {}),
  };
}
