/** A robot's log: the lines that the hub keeps, and beside them those that come live on the raw topic. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { TickerController } from "../../controllers/ticker.js";
import { TopicFollower, type TopicState } from "../../controllers/topic-follower.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { renderTopicStatus, renderTopicTrouble } from "../../elements/topic/topic-state.js";
import { formatClock } from "../../format/time.js";
import { KeptLog, logQuery } from "../../boards/kept-log.js";
import { LOG_LEVELS, RobotLog } from "../../boards/robot-log.js";
import type { LogPageShape } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { ALL_MESSAGES } from "../../topics/shared-topics.js";
import type { HubApi } from "../../wire/hub-api.js";
import { findLogLines } from "../../boards/robot-log-api.js";
import { plural } from "../../words/plural.js";
import "../../elements/base/icon.js";
import "../../elements/forms/button.js";
import { pastTurn, type BoardTileContext } from "./board-tile-entry.js";

const SHOWN = 200;
/** The hub is asked for new kept lines so often (ms). */
const KEPT_EVERY_MS = 10_000;
/** Who types is waited for (ms). */
const TYPING_MS = 400;
/** The topic of which the hub keeps lines. */
const KEPT_TOPIC = "/rosout";
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
      .text {
        white-space: pre-wrap;
      }
      /* Beside time and level no sentence fits: it stands below them. */
      @container (max-width: 28rem) {
        li {
          grid-template-columns: auto minmax(0, 1fr);
        }
        .text {
          grid-column: 1 / -1;
        }
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
  /** Those that the hub was asked for: the words once nobody types any more. */
  @state() private askedWords = "";
  @state() private loadingOlder = false;
  @consume({ context: apiContext, subscribe: true }) private readonly api: HubApi | undefined;

  private readonly log = new RobotLog();
  private readonly kept = new KeptLog();
  private readonly newest = new LoadController<LogPageShape>(this);
  private added: LogPageShape | undefined;
  private question = "";
  private typing: ReturnType<typeof setTimeout> | undefined;
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
    this.loadKept();
  }

  override disconnectedCallback(): void {
    clearTimeout(this.typing);
    super.disconnectedCallback();
  }

  override render(): TemplateResult {
    const nowMs = this.follower.nowMs();
    const stands = this.follower.stateAt(nowMs, this.context?.online ?? false);
    const age = this.follower.flow.ageMs(nowMs);
    const facts = { topic: this.topic, state: stands, why: this.follower.problem, age: age === null ? null : age / 1000, past: this.context?.past ?? null, zone: this.context?.zone ?? "UTC" };
    const level = this.chosen ?? this.level;
    const live = this.log.linesFor({ level, node: this.node, words: this.words }, SHOWN);
    const lines = this.kept.shownWith(live, this.node);
    return html`<div class="tools">
        <select aria-label=${msg("From level")} @change=${this.onLevel}>${renderOptions(LOG_LEVELS.map(([value, word]) => [String(value), word] as const), String(level))}</select>
        <input type="search" aria-label=${msg("Search the log")} placeholder=${msg("Search")} .value=${this.words} @input=${this.onSearch} />
        ${renderTopicStatus(facts)}
      </div>
      ${IN_ORDER.includes(stands) || this.kept.size > 0 ? html`<p>${this.summary(lines.length)}</p>` : html`<div>${renderTopicTrouble(facts)}</div>`}
      <ol aria-label=${msg("Lines, the newest first")} tabindex="0">
        ${repeat(
          lines,
          ({ key }) => key,
          (line) => html`<li class=${line.level >= 40 ? "grave" : line.level >= 30 ? "warn" : ""}>
            <time>${line.timeUs > 0 ? formatClock(line.timeUs, this.context?.zone ?? "UTC") : nothing}</time><span class="level">${line.word}</span>
            <span class="text" title=${line.source === "" ? nothing : line.source}><span class="node">${line.node}</span> ${line.text}</span>
          </li>`,
        )}
        ${this.kept.next === null ? nothing : html`<li class="older"><t-button ?disabled=${this.loadingOlder} @click=${this.onOlder}>${msg("Older")}</t-button></li>`}
      </ol>`;
  }

  private summary(shown: number): string {
    const { size } = this.log;
    if (this.newest.result.state === "failed") return msg(str`The kept lines cannot be loaded now; ${String(shown)} came live.`);
    if (this.kept.size > 0) {
      const lines = plural(shown, msg("1 line"), msg(str`${String(shown)} lines`));
      const until = this.context?.past == null ? lines : msg(str`${lines} up to this moment`);
      return this.kept.next === null ? msg(str`${until}, of which ${String(this.kept.size)} are kept.`) : msg(str`${until}, of which ${String(this.kept.size)} are kept; older ones below.`);
    }
    if (this.context?.past != null) return msg(str`${String(shown)} of ${String(size)} lines up to this moment, as far as the recording holds them.`);
    if (this.log.size === 0) return msg("No line since the tile was opened; the next appears by itself.");
    const dropped = this.log.dropped === 0 ? "" : msg(str`; ${String(this.log.dropped)} older ones are gone`);
    return msg(str`${String(shown)} of ${String(this.log.size)} lines since the tile was opened${dropped}.`);
  }

  private readonly onLevel = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.chosen = Number(event.target.value);
  };

  private readonly onSearch = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    this.words = event.target.value;
    clearTimeout(this.typing);
    this.typing = setTimeout(() => {
      this.askedWords = this.words;
    }, TYPING_MS);
  };

  /** Asks for the newest kept lines: for others at once, and for new ones now and then. */
  private loadKept(): void {
    const { api, context, askedWords } = this;
    if (api === undefined || context === null || this.topic !== KEPT_TOPIC) return;
    const toUs = context.past === null ? null : pastTurn(context.past);
    const question = `${context.site} ${logQuery({ level: this.chosen ?? this.level, node: this.node, words: askedWords, toUs, before: null })}`;
    if (question !== this.question) {
      this.question = question;
      this.kept.clear();
      this.added = undefined;
    }
    const turn = toUs === null && context.linked ? Math.floor(performance.now() / KEPT_EVERY_MS) : 0;
    this.newest.load(`${question} ${String(turn)}`, () => findLogLines(api, context.site, question.slice(context.site.length + 1)));
    const { result } = this.newest;
    if (result.state === "ready" && result.value !== this.added) {
      this.added = result.value;
      this.kept.addNewest(result.value);
    }
  }

  private readonly onOlder = async (): Promise<void> => {
    const { api, context, question } = this;
    const before = this.kept.next;
    if (api === undefined || context === null || before === null || this.loadingOlder) return;
    this.loadingOlder = true;
    try {
      const page = await findLogLines(api, context.site, `${question.slice(context.site.length + 1)}&before=${before}`);
      // Meanwhile something else may be looked for.
      if (question === this.question && before === this.kept.next) this.kept.addOlder(page);
    } catch {
      this.newest.invalidate();
    } finally {
      this.loadingOlder = false;
    }
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-log": LogBoardTile;
  }
}
