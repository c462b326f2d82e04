/** One-shot commands of a site over the connection. */

import { Store } from "../../state/store.js";
import { CommandDesk, type Asked } from "./command-machine.js";
import { freshId } from "./unique-id.js";
import type { Line } from "./drive-session.js";

export type Arguments = Readonly<Record<string, number | boolean | string>>;

/** The description's default; a gateway that has not accepted by then never will. */
const TTL_MS = 5000;
const BEAT_MS = 500;

export class CommandLine extends Store {
  readonly desk = new CommandDesk();
  private readonly given = new Map<string, { args: Arguments; units: Readonly<Record<string, string>> }>();
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly line: Pick<Line, "state" | "send" | "on" | "onState">,
    private readonly site: string,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
  }

  open(): void {
    this.stops = [
      this.line.on("command_news", (news) => {
        if (news.site !== this.site) return;
        this.desk.news(news);
        this.changed();
      }),
      this.line.on("problem", (news) => {
        const asked = news.about === "command" ? this.desk.unanswered() : null;
        if (!asked) return;
        this.desk.refused(asked.id, news.message, news.code === "offline");
        this.changed();
      }),
      this.line.on("site", (news) => {
        if (news.site === this.site && !news.online) this.lose();
      }),
      this.line.onState((state) => {
        if (state !== "open") this.lose();
      }),
    ];
    this.timer = setInterval(() => {
      if (this.desk.beat(this.now())) this.changed();
    }, BEAT_MS);
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
    clearInterval(this.timer);
  }

  /**
   * Asks once. Without a connection it is not kept for later: it is offline, at once.
   *
   * @param units - those that were shown beside the arguments; in others it is refused
   * @param over - the id of somebody else's command that it may interrupt
   */
  ask(
    device: string,
    command: string,
    args: Arguments,
    units: Readonly<Record<string, string>> = {},
    over = "",
  ): void {
    const id = freshId();
    this.given.set(`${device}/${command}`, { args, units });
    this.desk.ask(id, device, command, TTL_MS, this.now());
    const sent = this.line.send({ t: "command", site: this.site, device, command, id, args, units, over });
    if (!sent) this.desk.unsent(id);
    this.changed();
  }

  /** What was asked for last was refused because somebody else acts: ask for it all the same. */
  interrupt(asked: Asked): void {
    const given = this.given.get(`${asked.device}/${asked.command}`);
    if (given !== undefined) this.ask(asked.device, asked.command, given.args, given.units, asked.blockedBy);
  }

  /** Leave the other one to it. */
  leave(asked: Asked): void {
    this.desk.answered(asked.id);
    this.changed();
  }

  /** Ends what is under way, if the robot can; what came of it is told as news. */
  cancel(device: string, command: string): void {
    const asked = this.desk.latest(device, command);
    if (asked) this.line.send({ t: "cancel", site: this.site, device, id: asked.id });
  }

  private lose(): void {
    this.desk.lose();
    this.changed();
  }
}
