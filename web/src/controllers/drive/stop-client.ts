/** STOP (software) of one device over the connection. */

import { msg } from "@lit/localize";
import type { HeldStopUpdate, StopUpdate } from "../../generated/wire.js";
import { Store } from "../../state/store.js";
import { freshId } from "./unique-id.js";
import type { DriveConnection } from "./drive-session.js";
import { StopMachine } from "./stop-machine.js";

const BEAT_MS = 50;

export class StopClient extends Store {
  readonly desk = new StopMachine();
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;
  private siteOnline: boolean;
  private held_: HeldStopUpdate | null = null;

  constructor(
    private readonly line: Pick<DriveConnection, "state" | "send" | "onMessage" | "onState">,
    private readonly site: string,
    private readonly device: string,
    online: boolean,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
    this.siteOnline = online;
  }

  /** Whether a confirmation could come back. */
  get online(): boolean {
    return this.siteOnline && this.line.state === "open";
  }

  /** How far it got at gateways with the same key that wait; null: none does. */
  get held(): HeldStopUpdate | null {
    return this.held_;
  }

  get waitingMs(): number {
    return this.desk.waitingMs(this.now());
  }

  /** How long the second step of a reset stays open (ms). */
  get armedForMs(): number {
    const reset = this.desk.reset;
    return reset.kind === "armed" ? Math.max(0, reset.until - this.now()) : 0;
  }

  /**
   * @param known - what was said of STOP before, if anything was
   * @param held - the same of gateways that wait
   */
  open(known?: StopUpdate, held?: HeldStopUpdate): void {
    const isOurs = (news: { readonly site: string; readonly device: string }): boolean =>
      news.site === this.site && news.device === this.device;
    this.stops = [
      this.line.onMessage("stop_news", (news) => {
        if (!isOurs(news)) return;
        this.desk.applyUpdate(news, this.now());
        this.updateAndSchedule();
      }),
      this.line.onMessage("held_stop_news", (news) => {
        if (!isOurs(news)) return;
        this.held_ = news.held > 0 ? news : null;
        this.updateAndSchedule();
      }),
      this.line.onMessage("reset_key", (news) => {
        if (!isOurs(news)) return;
        this.desk.receiveResetKey(news.token, news.refused, this.now());
        this.updateAndSchedule();
      }),
      this.line.onMessage("problem", (news) => {
        if (news.about === "stop") {
          if (news.code === "offline") this.desk.markDelayed(news.message);
          else this.desk.markRefused(news.message);
        } else if (news.about === "reset") this.desk.receiveResetKey("", news.message, this.now());
        else return;
        this.updateAndSchedule();
      }),
      this.line.onMessage("site", (news) => {
        if (news.site !== this.site) return;
        this.siteOnline = news.online;
        if (!news.online) this.forgetRobot();
        this.updateAndSchedule();
      }),
      this.line.onState((state) => {
        if (state !== "open") this.forgetRobot();
        this.updateAndSchedule();
      }),
    ];
    this.held_ = held !== undefined && held.held > 0 ? held : null;
    if (known) {
      this.desk.applyUpdate(known, this.now());
      this.updateAndSchedule();
    }
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
    clearInterval(this.timer);
    this.timer = undefined;
  }

  /** STOP. It leaves before this returns, and again until the gateway names it. */
  pressStop(): void {
    this.sendStop(this.desk.pressStop(freshId(), this.now()));
    this.updateAndSchedule();
  }

  /** First step of a reset. */
  askReset(epoch: number): void {
    if (!this.desk.askReset(this.now())) return;
    this.sendReset(epoch, "");
  }

  /** Second step. */
  releaseStop(epoch: number): void {
    const token = this.desk.releaseStop(this.now());
    if (token !== null) this.sendReset(epoch, token);
    this.updateAndSchedule();
  }

  keepStopped(): void {
    this.desk.keepStopped();
    this.updateAndSchedule();
  }

  private forgetRobot(): void {
    this.desk.onLinkLost();
    this.held_ = null;
  }

  private sendReset(epoch: number, token: string): void {
    const sent = this.line.send({ t: "reset", site: this.site, device: this.device, epoch, token });
    if (!sent) this.desk.receiveResetKey("", msg("Not connected. Nothing was released."), this.now());
    this.updateAndSchedule();
  }

  private sendStop(id: string): void {
    this.line.send({ t: "stop", site: this.site, device: this.device, id });
  }

  private updateAndSchedule(): void {
    const busy = this.desk.phase === "sent" || this.desk.reset.kind !== "none";
    if (busy) this.timer ??= setInterval(this.onTimer, BEAT_MS);
    else {
      clearInterval(this.timer);
      this.timer = undefined;
    }
    this.notifyWatchers();
  }

  private readonly onTimer = (): void => {
    const again = this.desk.advance(this.now());
    if (again !== null) this.sendStop(again);
    this.updateAndSchedule();
  };
}
