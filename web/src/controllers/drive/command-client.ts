/** One-shot commands of a site over the connection. */

import { Store } from "../../state/store.js";
import { CommandMachine, type CommandRequest } from "./command-machine.js";
import { freshId } from "./unique-id.js";
import type { DriveConnection } from "./drive-session.js";

export type CommandArguments = Readonly<Record<string, number | boolean | string>>;

/** The description's default; a gateway that has not accepted by then never will. */
const TTL_MS = 5000;
const BEAT_MS = 500;

export class CommandClient extends Store {
  readonly desk = new CommandMachine();
  private readonly given = new Map<string, { args: CommandArguments; units: Readonly<Record<string, string>> }>();
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly line: Pick<DriveConnection, "state" | "send" | "onMessage" | "onState">,
    private readonly site: string,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
  }

  open(): void {
    this.stops = [
      this.line.onMessage("command_news", (news) => {
        if (news.site !== this.site) return;
        this.desk.applyUpdate(news);
        this.notifyWatchers();
      }),
      this.line.onMessage("problem", (news) => {
        const asked = news.about === "command" ? this.desk.newestUnanswered() : null;
        if (!asked) return;
        this.desk.markRefused(asked.id, news.message, news.code === "offline");
        this.notifyWatchers();
      }),
      this.line.onMessage("site", (news) => {
        if (news.site === this.site && !news.online) this.onLinkLost();
      }),
      this.line.onState((state) => {
        if (state !== "open") this.onLinkLost();
      }),
    ];
    this.timer = setInterval(() => {
      if (this.desk.advance(this.now())) this.notifyWatchers();
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
  sendCommand(
    device: string,
    command: string,
    args: CommandArguments,
    units: Readonly<Record<string, string>> = {},
    over = "",
  ): void {
    const id = freshId();
    this.given.set(`${device}/${command}`, { args, units });
    this.desk.addRequest(id, device, command, TTL_MS, this.now());
    const sent = this.line.send({ t: "command", site: this.site, device, command, id, args, units, over });
    if (!sent) this.desk.markUnsent(id);
    this.notifyWatchers();
  }

  /** What was asked for last was refused because somebody else acts: ask for it all the same. */
  interruptOther(asked: CommandRequest): void {
    const given = this.given.get(`${asked.device}/${asked.command}`);
    if (given !== undefined) this.sendCommand(asked.device, asked.command, given.args, given.units, asked.blockedBy);
  }

  /** Leave the other one to it. */
  dismissBlocked(asked: CommandRequest): void {
    this.desk.markAnswered(asked.id);
    this.notifyWatchers();
  }

  /** Ends what is under way, if the robot can; what came of it is told as news. */
  cancelCommand(device: string, command: string): void {
    const asked = this.desk.latestRequest(device, command);
    if (asked) this.line.send({ t: "cancel", site: this.site, device, id: asked.id });
  }

  private onLinkLost(): void {
    this.desk.onLinkLost();
    this.notifyWatchers();
  }
}
