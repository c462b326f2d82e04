/** One command to a group of sites: to each as a single one, and what became of it there. */

import { Store } from "../../state/store.js";
import type { CommandArguments } from "./command-client.js";
import { CommandMachine, isFinal, type CommandRequest } from "./command-machine.js";
import { freshId } from "./unique-id.js";
import type { DriveConnection } from "./drive-session.js";

/** The description's default; a gateway that has not accepted by then never will. */
const TTL_MS = 5000;
const BEAT_MS = 500;

/** What became of it at one site. */
export interface GroupCommandRow extends CommandRequest {
  readonly site: string;
}

/** What is asked of each of them. */
export interface GroupCommand {
  readonly device: string;
  readonly command: string;
  readonly args: CommandArguments;
  readonly units: Readonly<Record<string, string>>;
}

export class GroupCommandClient extends Store {
  private readonly machines = new Map<string, CommandMachine>();
  private asked: GroupCommand | null = null;
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly line: Pick<DriveConnection, "state" | "send" | "onMessage" | "onState">,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
  }

  /** Of the last group, in the order in which they were asked. */
  get rows(): readonly GroupCommandRow[] {
    const { asked } = this;
    if (asked === null) return [];
    return [...this.machines].flatMap(([site, machine]) => {
      const row = machine.latestRequest(asked.device, asked.command);
      return row === null ? [] : [{ site, ...row }];
    });
  }

  open(): void {
    this.stops = [
      this.line.onMessage("command_news", (news) => {
        const machine = this.machines.get(news.site);
        if (machine === undefined) return;
        machine.applyUpdate(news);
        this.notifyWatchers();
      }),
      this.line.onMessage("site", ({ site, online }) => {
        if (!online) this.loseLink(site);
      }),
      this.line.onState((state) => {
        if (state !== "open") for (const site of this.machines.keys()) this.loseLink(site);
      }),
    ];
    this.timer = setInterval(() => {
      const changed = [...this.machines.values()].map((machine) => machine.advance(this.now()));
      if (changed.includes(true)) this.notifyWatchers();
    }, BEAT_MS);
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
    clearInterval(this.timer);
  }

  /**
   * Asks each once; none waits for another, and nothing is kept for a site that is away.
   *
   * @returns what their ids begin with, by which the log joins them
   */
  sendCommand(sites: readonly string[], asked: GroupCommand): string {
    const group = `group-${freshId()}`;
    this.asked = asked;
    this.machines.clear();
    sites.forEach((site, at) => {
      const id = `${group}.${String(at + 1)}`;
      const machine = new CommandMachine();
      this.machines.set(site, machine);
      machine.addRequest(id, asked.device, asked.command, TTL_MS, this.now());
      if (!this.line.send({ t: "command", site, id, over: "", ...asked })) machine.markUnsent(id);
    });
    this.notifyWatchers();
    return group;
  }

  /** Ends what is under way, where the robot can. */
  cancelRunning(): void {
    for (const { site, device, id, phase } of this.rows) {
      if (!isFinal(phase)) this.line.send({ t: "cancel", site, device, id });
    }
  }

  private loseLink(site: string): void {
    this.machines.get(site)?.onLinkLost();
    this.notifyWatchers();
  }
}
