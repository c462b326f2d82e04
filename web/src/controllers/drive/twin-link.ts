/**
 * The twin of a device over the connection: its switch, its rehearsal, and how frames for it are said.
 *
 * A frame says *live* only while this page asked for it and the gateway says that it is so. Whatever else this page
 * believes, the gateway alone lets a frame through to the robot.
 */

import type { TwinUpdate } from "../../generated/wire.js";
import { Store } from "../../state/store.js";
import type { DriveConnection, FrameMessage } from "./drive-session.js";

export class TwinLink extends Store {
  /** By the gateway's own word; null before the first. */
  told: TwinUpdate | null = null;
  private wantsLive = false;
  private stops: (() => void)[] = [];

  /** @param onEnd - live has ended: what is held is to be let go */
  constructor(
    private readonly line: Pick<DriveConnection, "state" | "send" | "onMessage" | "onState">,
    private readonly site: string,
    private readonly device: string,
    private readonly onEnd: () => void,
  ) {
    super();
  }

  /** Whether what is driven here moves the robot. */
  get isLive(): boolean {
    return this.wantsLive && this.told?.live === true;
  }

  readonly messageOf: FrameMessage = ({ site, device }, { epoch, seq, tick, held_ms, linear, angular, picture_ms }) =>
    // The simulated vehicle has wheels that roll forward.
    ({ t: "twin_drive", site, device, epoch, seq, tick, held_ms, linear, angular, picture_ms, live: this.isLive });

  open(known?: TwinUpdate): void {
    this.told = known ?? null;
    this.stops = [
      this.line.onMessage("twin_news", (news) => {
        if (news.site !== this.site || news.device !== this.device) return;
        const was = this.isLive;
        this.told = news;
        // Ended at the gateway, for whatever reason: it is not live again before a person says so.
        if (!news.live && was) this.endLive();
        else if (was !== this.isLive) this.onEnd();
        this.notifyWatchers();
      }),
      this.line.onMessage("site", (news) => {
        if (news.site === this.site && !news.online) this.onLinkLost();
      }),
      this.line.onState((state) => {
        if (state !== "open") this.onLinkLost();
      }),
    ];
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
  }

  setLive(on: boolean, epoch: number): void {
    // Off counts at once, whatever becomes of the message.
    if (!on && this.isLive) this.endLive();
    this.wantsLive = on;
    this.send(on ? "live" : "alone", epoch);
    this.notifyWatchers();
  }

  clearRehearsal(epoch: number): void {
    this.send("clear", epoch);
  }

  private send(op: "live" | "alone" | "clear", epoch: number): void {
    const { site, device } = this;
    this.line.send({ t: "twin_ask", site, device, epoch, op });
  }

  private endLive(): void {
    this.wantsLive = false;
    this.onEnd();
  }

  private onLinkLost(): void {
    this.endLive();
    this.told = null;
    this.notifyWatchers();
  }
}
