/** Seat, STOP and hands of one device, built and taken apart together. */

import type { HeldStopUpdate, LeaseUpdate, StopUpdate } from "../../generated/wire.js";
import type { DeviceShape } from "../../generated/api.js";
import { DriveInputs } from "./drive-inputs.js";
import { DriveSession, type DriveConnection, type FrameMessage } from "./drive-session.js";
import { StopClient } from "./stop-client.js";

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
  private unwatch: (() => void) | null = null;

  /** @param messageOf - how its frames are said; without it they are the robot's */
  constructor(line: DriveConnection, site: string, device: DeviceShape, online: boolean, messageOf?: FrameMessage) {
    const { drive } = device;
    this.stop = new StopClient(line, site, device.id, online);
    const limits = drive && { maxSpeed: drive.max_speed, maxReverse: drive.max_reverse, maxTurn: drive.max_turn };
    const may = device.rights.includes("use");
    this.seat = limits && may ? new DriveSession(line, { site, device: device.id, limits }, online, undefined, messageOf) : null;
    this.hands = new DriveInputs(this.seat, this.stop);
  }

  openAll(known: KnownState): void {
    // STOP bars the seat in the same turn as it is pressed: zeros follow it down the line.
    this.unwatch = this.stop.subscribe(() => {
      if (!this.seat) return;
      if (this.stop.desk.blocksDriving) this.seat.block("stop");
      else if (this.seat.machine.isBlocked("stop")) this.seat.unblock("stop");
    });
    this.stop.open(known.stop, known.heldStop);
    this.seat?.open(known.lease);
    this.hands.open();
  }

  closeAll(): void {
    this.hands.close();
    this.seat?.close();
    this.stop.close();
    this.unwatch?.();
    this.unwatch = null;
  }
}
