/** STOP (software) of one device over the connection. */

import type { StopNews } from "../../generated/wire.js";
import { Store } from "../../state/store.js";
import { freshId } from "./unique-id.js";
import type { Line } from "./drive-session.js";
import { StopDesk } from "./stop-machine.js";

const BEAT_MS = 50;

export class StopLine extends Store {
  readonly desk = new StopDesk();
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;
  private siteOnline: boolean;

  constructor(
    private readonly line: Pick<Line, "state" | "send" | "on" | "onState">,
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

  get waiting(): number {
    return this.desk.waiting(this.now());
  }

  /** How long the second step of a reset stays open (ms). */
  get armedFor(): number {
    const reset = this.desk.reset;
    return reset.kind === "armed" ? Math.max(0, reset.until - this.now()) : 0;
  }

  /** @param known - what was said of STOP before, if anything was */
  open(known?: StopNews): void {
    const ours = (news: { readonly site: string; readonly device: string }): boolean =>
      news.site === this.site && news.device === this.device;
    this.stops = [
      this.line.on("stop_news", (news) => {
        if (!ours(news)) return;
        this.desk.news(news, this.now());
        this.settle();
      }),
      this.line.on("reset_key", (news) => {
        if (!ours(news)) return;
        this.desk.key(news.token, news.refused, this.now());
        this.settle();
      }),
      this.line.on("problem", (news) => {
        if (news.about === "stop") {
          if (news.code === "offline") this.desk.delayed(news.message);
          else this.desk.refused(news.message);
        } else if (news.about === "reset") this.desk.key("", news.message, this.now());
        else return;
        this.settle();
      }),
      this.line.on("site", (news) => {
        if (news.site !== this.site) return;
        this.siteOnline = news.online;
        if (!news.online) this.desk.lose();
        this.settle();
      }),
      this.line.onState((state) => {
        if (state !== "open") this.desk.lose();
        this.settle();
      }),
    ];
    if (known) {
      this.desk.news(known, this.now());
      this.settle();
    }
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
    clearInterval(this.timer);
    this.timer = undefined;
  }

  /** STOP. It leaves before this returns, and again until the gateway names it. */
  press(): void {
    this.send(this.desk.press(freshId(), this.now()));
    this.settle();
  }

  /** First step of a reset. */
  askReset(epoch: number): void {
    if (!this.desk.askReset(this.now())) return;
    this.reset(epoch, "");
  }

  /** Second step. */
  release(epoch: number): void {
    const token = this.desk.release(this.now());
    if (token !== null) this.reset(epoch, token);
    this.settle();
  }

  keepStopped(): void {
    this.desk.keepStopped();
    this.settle();
  }

  private reset(epoch: number, token: string): void {
    const sent = this.line.send({ t: "reset", site: this.site, device: this.device, epoch, token });
    if (!sent) this.desk.key("", "Not connected. Nothing was released.", this.now());
    this.settle();
  }

  private send(id: string): void {
    this.line.send({ t: "stop", site: this.site, device: this.device, id });
  }

  private settle(): void {
    const busy = this.desk.phase === "sent" || this.desk.reset.kind !== "none";
    if (busy) this.timer ??= setInterval(this.beat, BEAT_MS);
    else {
      clearInterval(this.timer);
      this.timer = undefined;
    }
    this.changed();
  }

  private readonly beat = (): void => {
    const again = this.desk.beat(this.now());
    if (again !== null) this.send(again);
    this.settle();
  };
}
