/**
 * STOP (software) of a group of devices, each as a single one: the same message to each, repeated until its own
 * gateway names it. None waits for another.
 */

import type { StopUpdate } from "../../generated/wire.js";
import { Store } from "../../state/store.js";
import { freshId } from "./unique-id.js";
import type { DriveConnection } from "./drive-session.js";
import { StopMachine, type StopMachinePhase } from "./stop-machine.js";

const BEAT_MS = 50;

/** A device that has STOP. */
export interface StopTarget {
  readonly site: string;
  readonly device: string;
}

/** How far STOP got at one of them. */
export interface GroupStopRow extends StopTarget {
  readonly phase: StopMachinePhase;
  readonly online: boolean;
  /** Since the press (ms), while it is not answered. */
  readonly waitingMs: number;
  /** From the press to the gateway's answer (ms); null before. */
  readonly answerMs: number | null;
  /** Who latched it; empty while it is not latched. */
  readonly who: string;
}

interface Pressed {
  readonly target: StopTarget;
  readonly machine: StopMachine;
}

export class GroupStopClient extends Store {
  private readonly pressed = new Map<string, Pressed>();
  private readonly away = new Set<string>();
  private stops: (() => void)[] = [];
  private timer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly line: Pick<DriveConnection, "state" | "send" | "onMessage" | "onState">,
    private readonly now: () => number = () => performance.now(),
  ) {
    super();
  }

  /** How it stands at each device that was stopped from here, in the order of the press. */
  get rows(): readonly GroupStopRow[] {
    return [...this.pressed.values()].map(({ target, machine }) => ({
      ...target,
      phase: machine.phase,
      online: this.line.state === "open" && !this.away.has(target.site),
      waitingMs: machine.waitingMs(this.now()),
      answerMs: machine.answerMs,
      who: machine.latchedBy?.who ?? "",
    }));
  }

  open(): void {
    this.stops = [
      this.line.onMessage("stop_news", (news) => {
        this.applyUpdate(news);
      }),
      this.line.onMessage("site", ({ site, online }) => {
        if (online) this.away.delete(site);
        else this.away.add(site);
        for (const { target, machine } of this.pressed.values()) if (target.site === site && !online) machine.onLinkLost();
        // One that is back is asked at once, and not at its next turn.
        if (online) this.sendWaiting(site);
        this.updateAndSchedule();
      }),
      this.line.onState((state) => {
        if (state !== "open") for (const { machine } of this.pressed.values()) machine.onLinkLost();
        this.updateAndSchedule();
      }),
    ];
  }

  close(): void {
    for (const stop of this.stops) stop();
    this.stops = [];
    clearInterval(this.timer);
    this.timer = undefined;
  }

  /**
   * STOP. All of them leave before this returns, those whose site is away, too: the hub may know better.
   *
   * @param away - sites that are known to be offline
   * @returns what their ids begin with, by which the log joins them
   */
  pressStop(targets: readonly StopTarget[], away: readonly string[] = []): string {
    const group = `group-${freshId()}`;
    for (const site of away) this.away.add(site);
    targets.forEach((target, at) => {
      const key = targetKey(target);
      const pressed = this.pressed.get(key) ?? { target, machine: new StopMachine() };
      this.pressed.set(key, pressed);
      this.sendStop(target, pressed.machine.pressStop(`${group}.${String(at + 1)}`, this.now()));
    });
    this.updateAndSchedule();
    return group;
  }

  /** What was stopped earlier is shown no more; it stays latched, of course. */
  forgetRows(): void {
    this.pressed.clear();
    this.updateAndSchedule();
  }

  private applyUpdate(news: StopUpdate): void {
    const pressed = this.pressed.get(targetKey(news));
    if (pressed === undefined) return;
    pressed.machine.applyUpdate(news, this.now());
    this.updateAndSchedule();
  }

  private sendWaiting(site: string): void {
    for (const { target, machine } of this.pressed.values()) {
      if (target.site !== site || machine.phase !== "sent") continue;
      this.sendStop(target, machine.pressStop("", this.now()));
    }
  }

  private sendStop({ site, device }: StopTarget, id: string): void {
    this.line.send({ t: "stop", site, device, id });
  }

  private updateAndSchedule(): void {
    const busy = [...this.pressed.values()].some(({ machine }) => machine.phase === "sent");
    if (busy) this.timer ??= setInterval(this.onTimer, BEAT_MS);
    else {
      clearInterval(this.timer);
      this.timer = undefined;
    }
    this.notifyWatchers();
  }

  private readonly onTimer = (): void => {
    for (const { target, machine } of this.pressed.values()) {
      // To a site that is away nothing is repeated: it is asked the moment it is back.
      if (this.away.has(target.site)) continue;
      const again = machine.advance(this.now());
      if (again !== null) this.sendStop(target, again);
    }
    this.updateAndSchedule();
  };
}

function targetKey({ site, device }: StopTarget): string {
  return `${site}\n${device}`;
}
