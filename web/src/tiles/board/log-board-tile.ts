/** A robot's log as it comes on a raw topic. What came before the tile was opened is not in it. */

import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { TickerController } from "../../controllers/ticker.js";
import { TopicFollower, type TopicState } from "../../controllers/topic-follower.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { renderTopicStatus, renderTopicTrouble } from "../../elements/topic/topic-state.js";
import { formatClock } from "../../format/time.js";
import { levelWord, LOG_LEVELS, RobotLog } from "../../boards/robot-log.js";
import { ALL_MESSAGES } from "../../topics/shared-topics.js";
import "../../elements/base/icon.js";
import type { BoardTileContext } from "./board-tile-entry.js";

const SHOWN = 200;
/** A log is silent while all is well: that it is quiet is nothing old. */
const IN_ORDER: readonly TopicState[] = ["live", "stale", "waiting"];

@customElement("t-tile-log")
export class LogBoardTile extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: auto auto minmax(0, 1fr);
        gap: var(--t-space-2);
        block-size: 100%;
        min-block-size: 0;
      }
      .tools {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2);
      }
      input {
        flex: 1 1 8rem;
      }
      ol {
        ${plainList}
        overflow: auto;
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
      }
      li {
        display: grid;
        grid-template-columns: 5.5rem 4.5rem minmax(0, 1fr);
        gap: 0 var(--t-space-2);
        padding-block: 1px;
        border-block-start: 1px solid var(--t-line);
        overflow-wrap: anywhere;
      }
      .node {
        color: var(--t-muted);
      }
      .grave .level {
        color: var(--t-bad);
        font-weight: var(--t-weight-strong);
      }
      .warn .level {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      p {
        ${quietText}
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property() topic = "/rosout";
  @property({ type: Number }) level = 20;
  @property() node = "";
  @state() private chosen: number | null = null;
  @state() private words = "";

  private readonly log = new RobotLog();
  private readonly follower = new TopicFollower(
    this,
    (tree) => {
      this.log.addMessage(tree);
    },
    () => {
      this.log.clear();
    },
  );

  constructor() {
    super();
    new TickerController(this);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("topic")) this.log.clear();
    this.follower.follow(this.context?.site ?? "", this.topic, ALL_MESSAGES, this.context?.past ?? null);
  }

  override render(): TemplateResult {
    const nowMs = this.follower.nowMs();
    const stands = this.follower.stateAt(nowMs, this.context?.online ?? false);
    const age = this.follower.flow.ageMs(nowMs);
    const facts = { topic: this.topic, state: stands, why: this.follower.problem, age: age === null ? null : age / 1000, past: this.context?.past ?? null, zone: this.context?.zone ?? "UTC" };
    const level = this.chosen ?? this.level;
    const lines = this.log.linesFor({ level, node: this.node, words: this.words }, SHOWN);
    return html`<div class="tools">
        <select aria-label="From level" @change=${this.onLevel}>${renderOptions(LOG_LEVELS.map(([value, word]) => [String(value), word] as const), String(level))}</select>
        <input type="search" aria-label="Search the log" placeholder="Search" .value=${this.words} @input=${this.onSearch} />
        ${renderTopicStatus(facts)}
      </div>
      ${IN_ORDER.includes(stands) ? html`<p>${this.summary(lines.length)}</p>` : html`<div>${renderTopicTrouble(facts)}</div>`}
      <ol aria-label="Lines, the newest first" tabindex="0">
        ${repeat(
          lines,
          ({ number }) => number,
          (line) => html`<li class=${line.level >= 40 ? "grave" : line.level >= 30 ? "warn" : ""}>
            <time>${line.timeUs > 0 ? formatClock(line.timeUs, this.context?.zone ?? "UTC") : nothing}</time><span class="level">${levelWord(line.level)}</span>
            <span><span class="node">${line.node}</span> ${line.message}</span>
          </li>`,
        )}
      </ol>`;
  }

  private summary(shown: number): string {
    const { size } = this.log;
    if (this.context?.past != null) return `${String(shown)} of ${String(size)} lines up to this moment, as far as the recording holds them.`;
    if (this.log.size === 0) return "No line since the tile was opened; the next appears by itself.";
    const dropped = this.log.dropped === 0 ? "" : `; ${String(this.log.dropped)} older ones are gone`;
    return `${String(shown)} of ${String(this.log.size)} lines since the tile was opened${dropped}.`;
  }

  private readonly onLevel = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.chosen = Number(event.target.value);
  };

  private readonly onSearch = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.words = event.target.value;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-log": LogBoardTile;
  }
}
