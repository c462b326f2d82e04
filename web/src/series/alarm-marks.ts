/** When alarms were raised and over, as marks on the live charts of what they are about. */

import { msg, str } from "@lit/localize";

/** What is needed of an event. */
export interface AlarmEvent {
  readonly time_us: number;
  readonly kind: string;
  /** Empty: about the whole site. */
  readonly device: string;
  readonly good: boolean;
  /** The alarm's name, and why after a colon. */
  readonly message: string;
}

export interface AlarmMark {
  /** µs since the epoch, UTC */
  readonly timeUs: number;
  readonly good: boolean;
  /** `Battery low raised` */
  readonly said: string;
}

const SHOWN: ReadonlySet<string> = new Set([msg("alarm raised"), msg("alarm cleared")]);
/** The charts show minutes: older ones than the last so many are not looked for. */
const MOST = 200;

export class AlarmMarks {
  private events: readonly AlarmEvent[] = [];
  private readonly lists = new Map<string, readonly AlarmMark[]>();

  /** Takes in events, in whatever order and also twice; those that are none of alarms are left out. */
  add(events: readonly AlarmEvent[]): void {
    const fresh = events.filter((event) => SHOWN.has(event.kind) && !this.events.some((known) => isSameEvent(known, event)));
    if (fresh.length === 0) return;
    this.events = [...this.events, ...fresh].sort((a, b) => a.time_us - b.time_us).slice(-MOST);
    this.lists.clear();
  }

  clear(): void {
    this.events = [];
    this.lists.clear();
  }

  /** Those of a device and of the whole site; the same array until something happens. */
  marksOf(device: string): readonly AlarmMark[] {
    const held = this.lists.get(device);
    if (held !== undefined) return held;
    const list = this.events
      .filter((event) => event.device === device || event.device === "")
      .map(({ time_us, good, kind, message }) => ({
        timeUs: time_us, good, said: (kind === "alarm raised" ? msg(str`${message.split(": ", 1)[0] ?? ""} raised`) : msg(str`${message.split(": ", 1)[0] ?? ""} over`)).trim(),
      }));
    this.lists.set(device, list);
    return list;
  }
}

function isSameEvent(a: AlarmEvent, b: AlarmEvent): boolean {
  return a.time_us === b.time_us && a.kind === b.kind && a.device === b.device;
}
