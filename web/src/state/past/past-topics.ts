/**
 * What recordings hold of raw topics, around the moment that a board shows: asked for in stretches of equal length,
 * and told to who follows a topic as the moment comes to each message.
 */

import type { MomentShape, RecordedTopicShape } from "../../generated/api.js";
import { SECOND_US } from "../../series/zone-clock.js";
import type { RecordedMessage, RecordedStretch, RecordedWish } from "../../topics/recorded-api.js";

/** What is asked of the hub. */
export interface PastTopicSource {
  moment(site: string, atUs: number, signal?: AbortSignal): Promise<MomentShape>;
  trees(site: string, wishes: readonly RecordedWish[], fromUs: number, toUs: number, signal?: AbortSignal): Promise<RecordedStretch>;
  bytes(site: string, wishes: readonly RecordedWish[], points: number, fromUs: number, toUs: number, signal?: AbortSignal): Promise<RecordedStretch>;
}

/**
 * - `loading`: it is not known yet
 * - `none`: no recording holds the topic at this moment, or none that one may have
 * - `waiting`: a recording does, and nothing had come yet
 * - `failed`: the hub did not say
 */
export type PastTopicKind = "loading" | "none" | "waiting" | "there" | "unreadable" | "failed";

export interface PastTopicState {
  readonly kind: PastTopicKind;
  /** Of its messages; empty where it is not known. */
  readonly type: string;
  readonly latched: boolean;
  /** Why it cannot be read. */
  readonly why: string;
}

export interface PastTopicListener {
  /** The moment was put elsewhere: what came before is not so. */
  readonly onReset: () => void;
  readonly onMessage: (message: RecordedMessage) => void;
  readonly onState: (state: PastTopicState) => void;
}

export type PastForm = "trees" | "bytes";

/** How long a stretch is (µs). */
export const STRETCH_US = 4 * SECOND_US;
/** After a jump who follows is told what came so shortly before (µs): parts of a whole come one by one. */
const RECENT_US: Readonly<Record<PastForm, number>> = { trees: 8 * SECOND_US, bytes: 2 * SECOND_US };
/** Messages are of the past: more large ones a second nobody sees when scrubbing (Hz). */
const MOST_RATE = 5;
/** Points of a cloud. */
const POINTS = 60_000;
const MOST_RUNNING = 2;
const MOST_KEPT = 12;
const MOST_BYTES = 96 * 1024 * 1024;
/** Questions for one stretch: it is left incomplete rather than asked for without end. */
const MOST_PIECES = 40;

interface KeptTopic {
  /** By time; those of before the stretch first. */
  readonly messages: RecordedMessage[];
  readonly spans: readonly RecordedTopicShape[];
}

interface KeptStretch {
  readonly topics: Map<string, KeptTopic>;
  readonly asked: Set<string>;
  /** What was not answered, by the time of asking. */
  failure: unknown;
  bytes: number;
}

interface Following {
  readonly form: PastForm;
  readonly wish: RecordedWish;
  readonly listener: PastTopicListener;
  /** Told up to here (µs); NaN before the first time. */
  toldUs: number;
  said: string;
}

export class PastTopics {
  private readonly followings = new Set<Following>();
  private readonly stretches: Readonly<Record<PastForm, Map<number, KeptStretch>>> = { trees: new Map(), bytes: new Map() };
  private readonly ending = new AbortController();
  private running = 0;
  private known: { readonly moment: MomentShape; readonly fromUs: number; readonly toUs: number } | null = null;
  private asking = false;
  private momentWanted = false;

  /**
   * @param us the moment that is shown (µs)
   * @param changed an answer has come, or somebody follows something else
   */
  constructor(
    private readonly site: string,
    private readonly source: PastTopicSource,
    private readonly us: () => number,
    private readonly changed: () => void,
  ) {}

  /** Tells a topic's messages as the moment comes to them; gives what ends it. */
  follow(form: PastForm, topic: string, rate: number, listener: PastTopicListener): () => void {
    const following: Following = { form, wish: { topic, rate: Math.min(rate, MOST_RATE) }, listener, toldUs: Number.NaN, said: "" };
    this.followings.add(following);
    this.changed();
    return () => {
      this.followings.delete(following);
    };
  }

  /** What recordings hold of the moment; null while it is not known. Who asks is told by `changed`. */
  get moment(): MomentShape | null {
    this.momentWanted = true;
    const us = this.us();
    if (this.isMomentKnown(us)) return this.known?.moment ?? null;
    void this.askMoment(us);
    return null;
  }

  private isMomentKnown(us: number): boolean {
    return this.known !== null && us >= this.known.fromUs && us <= this.known.toUs;
  }

  /** All that is followed is known of a moment, or will not be. */
  isReady(us: number): boolean {
    const index = indexOf(us);
    return [...this.followings].every(({ form, wish }) => {
      const stretch = this.stretches[form].get(index);
      return stretch !== undefined && (stretch.topics.has(wish.topic) || stretch.failure !== null);
    });
  }

  /**
   * Asks for what is not known of the moment, and of so much after it (µs).
   *
   * @param most questions that may run at a time
   */
  load(aheadUs: number, most = MOST_RUNNING): void {
    const us = this.us();
    if (this.momentWanted && !this.isMomentKnown(us)) void this.askMoment(us);
    // After a jump who follows is told what came shortly before.
    for (const form of ["trees", "bytes"] as const) {
      // The moment itself first.
      this.loadStretch(form, indexOf(us), most);
      for (let i = indexOf(us - RECENT_US[form]); i <= indexOf(us + aheadUs); i += 1) this.loadStretch(form, i, most);
    }
  }

  /** After a failure: ask once more. */
  retry(): void {
    for (const form of ["trees", "bytes"] as const) for (const [index, { failure }] of this.stretches[form]) if (failure !== null) this.stretches[form].delete(index);
  }

  /** Whoever follows is told what the moment has come to. `jumped`: it was put elsewhere. */
  advance(jumped: boolean): void {
    const us = this.us();
    for (const following of this.followings) {
      if (jumped) following.toldUs = Number.NaN;
      this.deliver(following, us);
    }
  }

  close(): void {
    this.ending.abort();
    this.followings.clear();
    for (const stretches of Object.values(this.stretches)) stretches.clear();
  }

  private deliver(following: Following, us: number): void {
    const { form, wish, listener } = following;
    const stretch = this.stretches[form].get(indexOf(us));
    const kept = stretch?.topics.get(wish.topic);
    const known = Number.isNaN(following.toldUs) ? this.knowsSince(form, wish.topic, us - RECENT_US[form], us) : kept !== undefined;
    if (kept === undefined || !known) {
      this.reportState(following, { kind: stretch?.failure == null ? "loading" : "failed", type: "", latched: false, why: "" });
      return;
    }
    const span = kept.spans.find(({ begin_us: begin, end_us: end }) => begin <= us && us <= end);
    if (span === undefined) {
      // What an earlier recording said is not of this moment.
      if (following.said !== "" && !Number.isNaN(following.toldUs)) listener.onReset();
      following.toldUs = Number.NaN;
      this.reportState(following, { kind: "none", type: "", latched: false, why: "" });
      return;
    }
    const { type, latched, problem: why } = span;
    const first = Number.isNaN(following.toldUs) || us < following.toldUs || following.toldUs < span.begin_us;
    const messages = this.knownBetween(form, wish.topic, first ? span.begin_us : following.toldUs, us, first);
    if (first) listener.onReset();
    const recent = first && !latched ? recentOf(messages, us - RECENT_US[form]) : messages;
    following.toldUs = us;
    const any = first ? recent.length > 0 : recent.length > 0 || following.said.startsWith("there");
    this.reportState(following, { kind: why !== "" ? "unreadable" : any ? "there" : "waiting", type, latched, why });
    for (const message of recent) listener.onMessage(message);
  }

  /** Whether all of a stretch of time has been answered. */
  private knowsSince(form: PastForm, topic: string, fromUs: number, toUs: number): boolean {
    for (let i = indexOf(fromUs); i <= indexOf(toUs); i += 1) {
      const stretch = this.stretches[form].get(i);
      if (i >= 0 && stretch?.topics.has(topic) !== true && (stretch?.failure ?? null) === null) return false;
    }
    return true;
  }

  /** Messages after `fromUs` up to `toUs`; those at `fromUs`, too, the `first` time. */
  private knownBetween(form: PastForm, topic: string, fromUs: number, toUs: number, first: boolean): readonly RecordedMessage[] {
    const found = new Map<string, RecordedMessage>();
    const begin = first ? Math.max(indexOf(fromUs), indexOf(toUs - RECENT_US[form])) : indexOf(fromUs);
    for (let i = begin; i <= indexOf(toUs); i += 1) {
      for (const message of this.stretches[form].get(i)?.topics.get(topic)?.messages ?? []) {
        // The last one before a stretch stands in the one before it, too.
        if (message.timeUs <= toUs && (first ? message.timeUs >= fromUs : message.timeUs > fromUs)) found.set(`${String(message.timeUs)} ${String(message.publishUs)} ${String(message.size)}`, message);
      }
    }
    return [...found.values()].sort((a, b) => a.timeUs - b.timeUs);
  }

  private reportState(following: Following, state: PastTopicState): void {
    const key = `${state.kind} ${state.type} ${state.why}`;
    if (following.said === key) return;
    following.said = key;
    following.listener.onState(state);
  }

  private loadStretch(form: PastForm, index: number, most: number): void {
    const wanted = new Map([...this.followings].filter((following) => following.form === form).map(({ wish }) => [wish.topic, wish]));
    if (wanted.size === 0 || index < 0) return;
    const stretches = this.stretches[form];
    let stretch = stretches.get(index);
    if (stretch !== undefined) markUsed(stretches, index, stretch);
    const missing = [...wanted.values()].filter(({ topic }) => stretch?.topics.has(topic) !== true && stretch?.asked.has(topic) !== true);
    if (missing.length === 0 || this.running >= most || (stretch?.failure ?? null) !== null) return;
    stretch ??= { topics: new Map(), asked: new Set(), failure: null, bytes: 0 };
    markUsed(stretches, index, stretch);
    void this.askFor(form, index, stretch, missing);
  }

  private async askFor(form: PastForm, index: number, stretch: KeptStretch, wishes: readonly RecordedWish[]): Promise<void> {
    for (const { topic } of wishes) stretch.asked.add(topic);
    this.running += 1;
    try {
      const found = await this.askPieces(form, index, wishes);
      for (const { topic } of wishes) {
        const messages = found.messages.filter((message) => message.topic === topic);
        stretch.topics.set(topic, { messages, spans: found.topics.filter((shape) => shape.topic === topic) });
        stretch.bytes += messages.reduce((sum, { size, tree }) => sum + size + 2 * tree.length, 0);
      }
    } catch (error) {
      if (!this.ending.signal.aborted) stretch.failure = error;
    }
    this.running -= 1;
    for (const { topic } of wishes) stretch.asked.delete(topic);
    if (this.ending.signal.aborted) return;
    forgetOldest(this.stretches[form]);
    this.changed();
  }

  /** The whole stretch, of which the hub gives only so much at once. */
  private async askPieces(form: PastForm, index: number, wishes: readonly RecordedWish[]): Promise<RecordedStretch> {
    const toUs = (index + 1) * STRETCH_US;
    const { signal } = this.ending;
    const topics = new Map<string, RecordedTopicShape>();
    const messages: RecordedMessage[] = [];
    let fromUs = index * STRETCH_US;
    for (let piece = 0; piece < MOST_PIECES && fromUs < toUs; piece += 1) {
      const found = form === "trees" ? await this.source.trees(this.site, wishes, fromUs, toUs, signal) : await this.source.bytes(this.site, wishes, POINTS, fromUs, toUs, signal);
      for (const shape of found.topics) topics.set(`${shape.topic} ${String(shape.begin_us)}`, shape);
      // What came before is asked for once.
      messages.push(...(piece === 0 ? found.messages : found.messages.filter(({ timeUs }) => timeUs >= fromUs)));
      if (found.untilUs <= fromUs) break;
      fromUs = found.untilUs;
    }
    return { topics: [...topics.values()], messages, untilUs: fromUs };
  }

  private async askMoment(us: number): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      const moment = await this.source.moment(this.site, us, this.ending.signal);
      this.known = { moment, ...validOf(moment, us) };
    } catch {
      // Said by what cannot be shown; asked again once the moment has moved.
      this.known = { moment: { topics: [], earlier_us: null, later_us: null, problems: [] }, fromUs: us, toUs: us };
    }
    this.asking = false;
    if (!this.ending.signal.aborted) this.changed();
  }
}

function indexOf(us: number): number {
  return Math.floor(us / STRETCH_US);
}

/** From when to when the same is true: within the recordings of the moment, or between the nearest. */
function validOf({ topics, earlier_us: earlier, later_us: later }: MomentShape, us: number): { readonly fromUs: number; readonly toUs: number } {
  const fromUs = Math.max(earlier === null ? 0 : earlier + 1, ...topics.map(({ begin_us: begin }) => begin));
  // What is not recorded yet may be so later: the hub is asked again after a minute of the moment.
  const open = topics.length === 0 && later === null ? us + 60 * SECOND_US : Infinity;
  const toUs = Math.min(later === null ? open : later - 1, ...topics.map(({ end_us: end }) => end));
  return { fromUs: Math.min(fromUs, us), toUs: Math.max(toUs, us) };
}

/** What came since; else the last that came at all. */
function recentOf(messages: readonly RecordedMessage[], sinceUs: number): readonly RecordedMessage[] {
  const recent = messages.filter(({ timeUs }) => timeUs >= sinceUs);
  return recent.length > 0 ? recent : messages.slice(-1);
}

/** The one used longest ago stands first. */
function markUsed(stretches: Map<number, KeptStretch>, index: number, stretch: KeptStretch): void {
  stretches.delete(index);
  stretches.set(index, stretch);
}

function forgetOldest(stretches: Map<number, KeptStretch>): void {
  let bytes = [...stretches.values()].reduce((sum, stretch) => sum + stretch.bytes, 0);
  for (const [index, stretch] of stretches) {
    // The newest always stay: the moment, what comes next, and what was asked for meanwhile.
    if (stretches.size <= 3 || (stretches.size <= MOST_KEPT && bytes <= MOST_BYTES)) return;
    stretches.delete(index);
    bytes -= stretch.bytes;
  }
}
