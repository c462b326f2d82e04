/** How a raw topic stands, in words: what keeps its messages from coming, and how old the newest is. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import type { TopicState } from "../../controllers/topic-follower.js";
import { formatAge, formatDuration } from "../../format/duration.js";
import type { StatusKind } from "../feedback/status.js";
import "../feedback/banner.js";
import "../feedback/empty.js";
import "../feedback/loading.js";
import "../feedback/problem.js";
import type { PastBoard } from "../../state/past/past-board.js";
import "../feedback/status.js";
import "./unrecorded.js";

/** What is said of a topic besides its message. */
export interface TopicFacts {
  readonly topic: string;
  readonly state: TopicState;
  /** The hub's sentence about an error. */
  readonly why: string;
  /** Of the newest message (s); null before one came. */
  readonly age: number | null;
  /** The past moment that is shown. */
  readonly past?: PastBoard | null;
  readonly zone?: string;
}

const KINDS: Readonly<Record<TopicState, StatusKind>> = {
  loading: "busy",
  waiting: "unknown",
  live: "online",
  stale: "stale",
  ended: "offline",
  away: "offline",
  lost: "offline",
  error: "warn",
  forbidden: "bad",
  unrecorded: "unknown",
};
const WORDS: Readonly<Record<TopicState, string>> = {
  loading: msg("asking"),
  waiting: msg("no message yet"),
  live: msg("live"),
  stale: msg("stale"),
  ended: msg("no longer published"),
  away: msg("gateway away"),
  lost: msg("connection lost"),
  error: msg("not readable"),
  forbidden: msg("not yours"),
  unrecorded: msg("not recorded"),
};
/** Of a past moment nothing is live. */
const PAST_WORDS: Readonly<Partial<Record<TopicState, string>>> = { live: msg("recorded"), stale: msg("recorded"), loading: msg("looking"), waiting: msg("nothing yet") };

/** A shape and a word, with the age of the newest message. */
export function renderTopicStatus({ state, age, past = null }: TopicFacts): TemplateResult {
  const aged = age === null || state === "forbidden" || state === "unrecorded" ? "" : state === "live" && age < 2 ? "" : `, ${formatAge(age)}`;
  if (past !== null) return html`<t-status kind=${state === "error" ? "warn" : "unknown"} word=${`${PAST_WORDS[state] ?? WORDS[state]}${aged}`}></t-status>`;
  return html`<t-status kind=${KINDS[state]} word=${`${WORDS[state]}${aged}`}></t-status>`;
}

/** What stands in the place of a message, or above an old one; nothing while it is live. */
export function renderTopicTrouble({ topic, state, why, age, past = null, zone = "UTC" }: TopicFacts): TemplateResult | typeof nothing {
  const before = age !== null;
  if (past !== null) {
    if (state === "loading") return html`<t-loading what=${msg(str`Looking for ${topic} in the recordings`)}></t-loading>`;
    if (state === "waiting") return html`<t-empty heading=${msg("No message yet")} icon="history"><p>${msg(html`The recording holds <code>${topic}</code>, and nothing had come on it by this moment.`)}</p></t-empty>`;
    if (state === "stale") return nothing;
  }
  switch (state) {
    case "unrecorded":
      return html`<t-unrecorded .past=${past} zone=${zone} what=${msg(str`${topic} is in no recording of this moment.`)}></t-unrecorded>`;
    case "live":
      return nothing;
    case "loading":
      return html`<t-loading what=${msg(str`Asking the robot for ${topic}`)}></t-loading>`;
    case "waiting":
      return html`<t-empty heading=${msg("No message yet")} icon="live"><p>${msg(html`Nothing has come on <code>${topic}</code> since you opened it. The next message appears here by itself.`)}</p></t-empty>`;
    case "stale":
      return html`<t-banner kind="warn">${msg(str`No message for ${formatDuration(age ?? 0)}: this is the last one, and it may not be true any more.`)}</t-banner>`;
    case "ended":
      return html`<t-banner kind="warn">${msg("Nobody publishes this topic any more. It goes on by itself when somebody does.")}</t-banner>`;
    case "away":
      return before
        ? html`<t-banner kind="warn">${msg("The robot's gateway is not connected: this is the last message that came.")}</t-banner>`
        : html`<t-empty heading=${msg("The gateway is away")} icon="unlinked"><p>${msg("The robot is heard again when its gateway has connected.")}</p></t-empty>`;
    case "lost":
      return before
        ? html`<t-banner kind="warn">${msg("The connection to the hub is lost; this page tries again by itself.")}</t-banner>`
        : html`<t-problem what=${msg("The topic cannot be had now.")} how=${msg("The hub does not answer, or the topic is not yours to follow. This page tries again by itself.")}></t-problem>`;
    case "error":
      return html`<t-problem what=${msg("The messages of this topic cannot be shown.")} how=${why}></t-problem>`;
    case "forbidden":
      return html`<t-problem what=${msg("You may not follow this topic.")} how=${why === "" ? msg("An admin of this hub can give you the right.") : why}></t-problem>`;
  }
}
