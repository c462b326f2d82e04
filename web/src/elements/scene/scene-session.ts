/** What a scene hears: the topics of a site by kind, followed while the scene is looked at, into one model. */

import { msg, str } from "@lit/localize";
import type { TopicShape } from "../../generated/api.js";
import { isCalibrated } from "../../scene/camera-model.js";
import { MessageError, MessageReader } from "../../scene/cdr.js";
import { choosePicture, readPackedPicture, readPlainPicture, type PictureSource } from "../../scene/picture-messages.js";
import { isShownAtFirst, isSwitched, sceneKind, type SceneKind } from "../../scene/scene-topics.js";
import { SceneModel } from "../../scene/scene-model.js";
import type { OpenPictures, PictureListener, StreamPictures } from "../../scene/stream-pictures.js";
import type { TopicBytes } from "../../generated/wire.js";
import { ByteTopics, type ByteListener, type ByteWish, type ByteTopicState, type OpenBytes } from "../../topics/byte-topics.js";
import { MessagePictures } from "./message-pictures.js";

/** Points of a cloud that are drawn without a pause on a small computer. */
const POINTS = 100_000;
/** Pictures a second of a raw topic: each pixel of a plain one goes over the line. */
const PICTURE_RATES = { packed: 10, plain: 2 } as const;

/** A topic as the hub lists it, or a recording. */
export type SceneTopicEntry = Pick<TopicShape, "topic" | "type" | "problem"> & { readonly camera?: string };

/** Where a scene gets what it shows. */
export interface SceneSources {
  /** None: sockets to the hub. */
  readonly open?: OpenBytes | undefined;
  readonly nowMs?: (() => number) | undefined;
  readonly openPictures: OpenPictures;
}

export interface SceneTopic {
  readonly topic: string;
  readonly kind: SceneKind;
  readonly shown: boolean;
}

export class SceneSession {
  readonly model: SceneModel;
  private readonly bytes: ByteTopics;
  private readonly chosen = new Map<string, boolean>();
  private known: readonly { readonly topic: string; readonly kind: SceneKind }[] = [];
  private readonly problems = new Map<string, string>();
  /** Why described cameras give no pictures. */
  private readonly troubles = new Map<string, string>();
  /** Calibrations whose described camera has no pictures: those beside it are shown. */
  private readonly missing = new Set<string>();
  private readonly cameras: StreamPictures;
  private readonly decoder: MessagePictures;
  /** Of each calibration: whose pictures it places; null: it has none. */
  private sources: ReadonlyMap<string, PictureSource | null> = new Map<string, PictureSource | null>();
  private key = "";
  private closed = false;

  constructor(
    site: string,
    private readonly listener: { readonly onChange: () => void; readonly onState: () => void },
    { open, nowMs, openPictures }: SceneSources,
  ) {
    this.model = new SceneModel(nowMs);
    const onPicture: PictureListener["onPicture"] = (topic, picture) => {
      this.model.setPicture(topic, picture);
      this.listener.onChange();
    };
    this.decoder = new MessagePictures({
      onPicture: (topic, picture) => {
        // Meanwhile the camera's own may have come.
        if (this.sourceOf(topic)?.from === "topic") onPicture(topic, picture);
        else picture?.image.close();
      },
      onTrouble: this.noteIn(this.problems),
    });
    this.cameras = openPictures({
      onPicture,
      onTrouble: this.noteIn(this.troubles),
      onMissing: (topic, missing) => {
        if (missing) this.missing.add(topic);
        else this.missing.delete(topic);
        // Neither shows what the other has shown.
        if (this.besideOf(topic) !== null) this.model.setPicture(topic, null);
        this.follow();
        this.listener.onState();
      },
    });
    const heard: ByteListener = {
      onBytes: (topic, message) => {
        this.showPictures(topic, message);
        const found = this.known.find((followed) => followed.topic === topic);
        if (found === undefined) return;
        this.read(topic, found.kind, () => {
          this.model.applyMessage(topic, found.kind, message, this.model.nowMs() - message.age_ms);
        });
        this.listener.onChange();
      },
      onState: listener.onState,
    };
    this.bytes = new ByteTopics(site, heard, document, open);
  }

  /** Another moment is shown: what was heard is not so. */
  reset(): void {
    this.model.reset((topic) => this.sourceOf(topic)?.from === "stream");
    this.problems.clear();
    this.listener.onChange();
  }

  /** A topic begins anew. */
  forget(topic: string): void {
    this.model.forget(topic, this.sourceOf(topic)?.from === "stream");
    this.listener.onChange();
  }

  /** The topics that there are; with `only`, no others of those that are switched. */
  setTopics(topics: readonly SceneTopicEntry[], only: readonly string[]): void {
    const key = JSON.stringify([topics.map(({ topic, type, problem, camera = "" }) => [topic, type, problem, camera]), only]);
    if (key === this.key) return;
    this.key = key;
    this.known = topics.flatMap(({ topic, type, problem }) => {
      const kind = problem === "" ? sceneKind(topic, type) : null;
      return kind === null || (only.length > 0 && isSwitched(kind) && !only.includes(topic)) ? [] : [{ topic, kind }];
    });
    const entries = new Map(topics.map((entry) => [entry.topic, entry]));
    this.sources = new Map(
      this.known.flatMap(({ topic, kind }) => {
        const entry = entries.get(topic);
        return kind.kind === "camera" && entry !== undefined ? [[topic, choosePicture(entry, topics)] as const] : [];
      }),
    );
    this.follow();
  }

  get topics(): readonly SceneTopic[] {
    return this.known.map(({ topic, kind }) => ({ topic, kind, shown: this.chosen.get(topic) ?? isShownAtFirst(topic, kind) }));
  }

  show(topic: string, shown: boolean): void {
    this.chosen.set(topic, shown);
    if (!shown) this.model.forget(topic);
    this.follow();
    this.listener.onChange();
  }

  stateOf(topic: string): ByteTopicState | null {
    return this.bytes.stateOf(topic);
  }

  /** Why a topic cannot be shown; empty where it can. */
  problemOf(topic: string): string {
    const source = this.sourceOf(topic);
    const own = this.problems.get(topic) ?? this.bytes.stateOf(topic)?.why ?? "";
    if (own !== "" || source === undefined) return own;
    if (source === null) return msg("No pictures beside it that you may see: they would be in the same namespace");
    const layer = this.model.layers.get(topic);
    if (layer?.content.shape === "camera" && !isCalibrated(layer.content.info)) return msg("This camera is not calibrated: it does not say where its pixels look");
    return (source.from === "topic" ? this.bytes.stateOf(source.topic)?.why : this.troubles.get(topic)) ?? "";
  }

  close(): void {
    this.closed = true;
    this.bytes.close();
    this.cameras.close();
    this.decoder.close();
    this.model.reset();
  }

  private follow(): void {
    if (this.closed) return;
    const shown = this.topics.filter((topic) => topic.shown || !isSwitched(topic.kind));
    const wishes = new Map<string, ByteWish>(shown.map(({ topic, kind }) => [topic, { topic, rate: kind.rate, points: POINTS }]));
    const streams = new Map<string, string>();
    for (const { topic } of shown) {
      const described = this.sources.get(topic);
      const source = this.sourceOf(topic);
      // Also while others stand in for it: its own may come.
      if (described?.from === "stream") streams.set(topic, described.stream);
      if (source?.from === "topic") wishes.set(source.topic, { topic: source.topic, rate: PICTURE_RATES[source.packed ? "packed" : "plain"], points: POINTS });
    }
    this.bytes.followAll([...wishes.values()]);
    this.cameras.followStreams(streams);
  }

  /** Whose pictures a calibration places now; null: it has none, undefined of what is none. */
  private sourceOf(topic: string): PictureSource | null | undefined {
    return this.missing.has(topic) ? (this.besideOf(topic) ?? this.sources.get(topic)) : this.sources.get(topic);
  }

  private besideOf(topic: string): PictureSource | null {
    const source = this.sources.get(topic);
    return source?.from === "stream" ? source.beside : null;
  }

  private noteIn(words: Map<string, string>): PictureListener["onTrouble"] {
    return (topic, why) => {
      if ((words.get(topic) ?? "") === why) return;
      words.set(topic, why);
      this.listener.onState();
    };
  }

  /** A picture is shown by each calibration that speaks of it. */
  private showPictures(topic: string, message: TopicBytes): void {
    for (const { topic: key, kind, shown } of this.sources.size === 0 ? [] : this.topics) {
      const source = this.sourceOf(key);
      if (source?.from !== "topic" || source.topic !== topic || !shown) continue;
      const heardMs = this.model.nowMs() - message.age_ms;
      this.read(key, kind, () => {
        const reader = new MessageReader(message.data, message.encoding);
        void this.decoder.showMessage(key, source.packed ? readPackedPicture(reader) : readPlainPicture(reader), heardMs, source.rectified);
      });
    }
  }

  /** Does what reads a message; what is none is said beside its topic. */
  private read(topic: string, { name }: Pick<SceneKind, "name">, act: () => void): void {
    try {
      act();
      this.problems.delete(topic);
    } catch (error) {
      if (!(error instanceof MessageError || error instanceof RangeError)) throw error;
      this.problems.set(topic, msg(str`${name}: its messages are not what they should be: ${error.message}`));
      this.listener.onState();
    }
  }
}
