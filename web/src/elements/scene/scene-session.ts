/** What a scene hears: the topics of a site by kind, followed while the scene is looked at, into one model. */

import { msg, str } from "@lit/localize";
import type { TopicShape } from "../../generated/api.js";
import { MessageError } from "../../scene/cdr.js";
import { isShownAtFirst, isSwitched, sceneKind, type SceneKind } from "../../scene/scene-topics.js";
import { SceneModel } from "../../scene/scene-model.js";
import { ByteTopics, type ByteListener, type ByteTopicState, type OpenBytes } from "../../topics/byte-topics.js";

/** Points of a cloud that are drawn without a pause on a small computer. */
const POINTS = 100_000;

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
  private key = "";

  constructor(
    site: string,
    private readonly listener: { readonly onChange: () => void; readonly onState: () => void },
    open?: OpenBytes,
    nowMs?: () => number,
  ) {
    this.model = new SceneModel(nowMs);
    const heard: ByteListener = {
      onBytes: (topic, message) => {
        const found = this.known.find((followed) => followed.topic === topic);
        if (found === undefined) return;
        try {
          this.model.applyMessage(topic, found.kind, message, this.model.nowMs() - message.age_ms);
          this.problems.delete(topic);
        } catch (error) {
          if (!(error instanceof MessageError || error instanceof RangeError)) throw error;
          this.problems.set(topic, msg(str`${found.kind.name}: its messages are not what they should be: ${error.message}`));
          this.listener.onState();
        }
        this.listener.onChange();
      },
      onState: listener.onState,
    };
    this.bytes = new ByteTopics(site, heard, document, open);
  }

  /** Another moment is shown: what was heard is not so. */
  reset(): void {
    this.model.reset();
    this.problems.clear();
    this.listener.onChange();
  }

  /** The topics that there are; with `only`, no others of those that are switched. */
  setTopics(topics: readonly Pick<TopicShape, "topic" | "type" | "problem">[], only: readonly string[]): void {
    const key = JSON.stringify([topics.map(({ topic, type, problem }) => [topic, type, problem]), only]);
    if (key === this.key) return;
    this.key = key;
    this.known = topics.flatMap(({ topic, type, problem }) => {
      const kind = problem === "" ? sceneKind(topic, type) : null;
      return kind === null || (only.length > 0 && isSwitched(kind) && !only.includes(topic)) ? [] : [{ topic, kind }];
    });
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
    return this.problems.get(topic) ?? this.bytes.stateOf(topic)?.why ?? "";
  }

  close(): void {
    this.bytes.close();
  }

  private follow(): void {
    this.bytes.followAll(this.topics.filter(({ kind, shown }) => shown || !isSwitched(kind)).map(({ topic, kind }) => ({ topic, rate: kind.rate, points: POINTS })));
  }
}
