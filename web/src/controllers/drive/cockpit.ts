/** Seat, STOP and hands of one device, built and taken apart together. */

import type { DeviceInfo } from "../../wire/api.js";
import { Hands } from "./hands.js";
import { DriveSeat, type Line } from "./seat.js";
import { StopLine } from "./stop-line.js";

export class Cockpit {
  readonly stop: StopLine;
  /** Null for someone who may not drive this device. */
  readonly seat: DriveSeat | null;
  private readonly hands: Hands;
  private unwatch: (() => void) | null = null;

  constructor(line: Line, site: string, device: DeviceInfo, online: boolean) {
    const { drive } = device;
    this.stop = new StopLine(line, site, device.id, online);
    const limits = drive && { maxSpeed: drive.max_speed, maxReverse: drive.max_reverse, maxTurn: drive.max_turn };
    const may = device.rights.includes("use");
    this.seat = limits && may ? new DriveSeat(line, { site, device: device.id, limits }, online) : null;
    this.hands = new Hands(this.seat, this.stop);
  }

  open(): void {
    // STOP bars the seat in the same turn as it is pressed: zeros follow it down the line.
    this.unwatch = this.stop.watch(() => {
      if (!this.seat) return;
      if (this.stop.desk.bars) this.seat.bar("stop");
      else if (this.seat.machine.barred("stop")) this.seat.lift("stop");
    });
    this.stop.open();
    this.seat?.open();
    this.hands.open();
  }

  close(): void {
    this.hands.close();
    this.seat?.close();
    this.stop.close();
    this.unwatch?.();
    this.unwatch = null;
  }
}
