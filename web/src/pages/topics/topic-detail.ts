/** One raw topic: its newest message as a tree, or in its own form; followed while it is looked at. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { TopicFollower, type TopicState } from "../../controllers/topic-follower.js";
import { base, quietText, raisedBox } from "../../elements/base/base-style.js";
import type { ChoiceOption } from "../../elements/forms/choice.js";
import { control } from "../../elements/forms/input-style.js";
import type { FieldChoice } from "../../elements/topic/message-tree.js";
import { renderTopicStatus, renderTopicTrouble, type TopicFacts } from "../../elements/topic/topic-state.js";
import { formatBytes } from "../../format/bytes.js";
import { countedText } from "../../format/number.js";
import { plural } from "../../words/plural.js";
import type { TopicMessage } from "../../generated/wire.js";
import { sessionContext } from "../../state/contexts.js";
import { isSiteAdmin } from "../../state/rights.js";
import { sitePath } from "../../state/router.js";
import { topicTile } from "../../tiles/catalog.js";
import { FieldTraces } from "../../topics/field-traces.js";
import { ALL_MESSAGES } from "../../topics/shared-topics.js";
import type { TopicField } from "./new-signal.js";
import { rateText } from "./topic-list.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/topic/field-plot.js";
import "../../elements/topic/message-tree.js";
import "./signal-dialog.js";

/** Messages a second, of a topic that comes oftener: what a person can read. */
const RATE = 4;
/** In the place of a message there is only what keeps it from coming. */
const INSTEAD: readonly TopicState[] = ["loading", "waiting", "forbidden"];

interface HeldMessage {
  readonly message: TopicMessage;
  readonly tree: unknown;
}

@customElement("t-topic")
export class TopicDetail extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
        gap: var(--t-space-4);
        padding: var(--t-space-5);
        ${raisedBox}
        min-inline-size: 0;
      }
      .head {
        display: grid;
        gap: var(--t-space-1);
      }
      h2 {
        font-family: var(--t-mono);
        overflow-wrap: anywhere;
      }
      .back {
        display: none;
        align-items: center;
        min-block-size: var(--t-touch);
        font-weight: var(--t-weight-strong);
      }
      .facts,
      .tools {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-4);
      }
      .facts {
        ${quietText}
        font-variant-numeric: tabular-nums;
        overflow-wrap: anywhere;
      }
      .tools {
        gap: var(--t-space-2);
      }
      .tools input {
        flex: 1 1 9rem;
      }
      .old {
        opacity: 0.8;
      }
      summary {
        min-block-size: var(--t-touch);
        align-content: center;
        font-weight: var(--t-weight-strong);
        cursor: pointer;
      }
      pre {
        margin: 0;
        max-block-size: 24rem;
        overflow: auto;
        padding: var(--t-space-3);
        background: var(--t-raised);
        border-radius: var(--t-radius-s);
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
      }
      @media (max-width: 60rem) {
        .back {
          display: inline-flex;
        }
      }
      @media (max-width: 45rem) {
        :host {
          padding: var(--t-space-4);
        }
      }
    `,
  ];

  @property() site = "";
  @property() topic = "";
  /** Of its messages, as far as it is known. */
  @property() type = "";
  @property({ type: Boolean }) online = false;
  /** A field that is to become a signal, by its path; empty for none. */
  @property() asked = "";

  /** What is held while it is paused; null while it is not. */
  @state() private held: HeldMessage | null = null;
  @state() private search = "";
  @state() private view: "tile" | "tree" = "tile";
  /** What an admin makes a signal of. */
  @state() private wanted: TopicField | null = null;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly plots = new FieldTraces();
  private readonly follower = new TopicFollower(this, (tree, nowMs) => {
    this.plots.addMessage(tree, nowMs);
  });

  constructor() {
    super();
    new TickerController(this);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("site") || changed.has("topic")) {
      this.held = null;
      this.search = "";
      this.wanted = null;
      this.plots.choose([]);
    }
    if ((changed.has("asked") || changed.has("topic")) && this.asked !== "" && this.type !== "" && this.mayMakeSignals()) this.makeSignal(this.asked);
    // What the list says, until the topic itself says it: so the rate is right from the beginning.
    const tile = topicTile(this.follower.update?.type ?? this.type);
    // A tile follows the same topic: at its rate, so that one socket does for both.
    this.follower.follow(this.site, this.topic, tile === null ? RATE : ALL_MESSAGES);
    void tile?.load();
  }

  override render(): TemplateResult {
    const nowMs = performance.now();
    const facts = this.facts(nowMs);
    const tile = topicTile(this.follower.update?.type ?? "");
    const tiled = tile !== null && this.view === "tile" && facts.state !== "forbidden";
    return html`
      <div class="head">
        <a class="back" href=${sitePath(this.site, "topics")}>${msg("All topics")}</a>
        <h2>${this.topic}</h2>
        ${this.renderFacts(facts)}
      </div>
      ${this.renderTools(tile !== null, tiled)}
      ${renderTopicTrouble(facts)}
      ${tiled ? tile.render({ site: this.site, topic: this.topic, online: this.online, bare: true }) : this.renderMessage(facts)}
      ${this.renderDefinition()}
      <t-signal-dialog .site=${this.site} .wanted=${this.wanted} @t-close=${this.endSignal}></t-signal-dialog>
    `;
  }

  private renderFacts(facts: TopicFacts): TemplateResult {
    const { update, flow, message } = this.follower;
    const rate = rateText(flow.hertz);
    return html`<p class="facts">
      ${renderTopicStatus(facts)}
      ${update === null || update.type === "" ? nothing : html`<code>${update.type}</code>`}
      ${rate === "" ? nothing : html`<span>${rate}</span>`}
      ${message === null ? nothing : html`<span>${formatBytes(message.size)}</span>`}
      ${update?.latched === true ? html`<span title=${msg("Who comes later gets its last messages, too")}>${msg("latched", { id: "latched.topic" })}</span>` : nothing}
      ${update === null || update.max_rate === 0 ? nothing : html`<span>${msg(str`at most ${String(update.max_rate)} Hz by the description`)}</span>`}
    </p>`;
  }

  private renderTools(hasTile: boolean, tiled: boolean): TemplateResult | typeof nothing {
    if (this.follower.message === null) return nothing;
    const views: readonly ChoiceOption[] = [
      { id: "tile", label: msg("Diagnostics") },
      { id: "tree", label: msg("Message") },
    ];
    return html`<div class="tools" role="toolbar" aria-label=${msg("Message")}>
      ${hasTile ? html`<t-choice label=${msg("Shown as")} .options=${views} chosen=${this.view} @t-choose=${this.chooseView}></t-choice>` : nothing}
      ${tiled
        ? nothing
        : html`<t-button kind=${this.held === null ? "plain" : "primary"} pressed=${this.held === null ? "false" : "true"} @click=${this.togglePause}>${this.held === null ? msg("Pause") : msg("Resume")}</t-button>
            <input type="search" aria-label=${msg("Search a field by its path")} placeholder=${msg("Field, such as header.stamp")} .value=${this.search} @input=${this.onSearch} />`}
    </div>`;
  }

  private renderMessage({ state: how }: TopicFacts): TemplateResult | typeof nothing {
    const { message, tree } = this.follower;
    const shown = this.held ?? (message === null ? null : { message, tree });
    if (shown === null || INSTEAD.includes(how)) return nothing;
    const newer = this.held === null || message === null ? 0 : Math.max(0, message.seq - this.held.message.seq);
    return html`${this.held === null ? nothing : html`<p class="muted" role="status">${newer === 0 ? msg("Paused. Nothing newer has come.") : plural(newer, msg(str`Paused. ${countedText(newer)} newer message has come.`), msg(str`Paused. ${countedText(newer)} newer messages have come.`))}</p>`}
      <t-field-plot .traces=${this.plots.traces} .nowMs=${performance.now()} @t-plot=${this.onPlot}></t-field-plot>
      <t-message-tree class=${how === "live" && this.held === null ? "" : "old"} .value=${shown.tree} search=${this.search} .plotted=${this.plots.paths} ?signals=${this.mayMakeSignals()} @t-plot=${this.onPlot} @t-make-signal=${this.onMakeSignal}></t-message-tree>`;
  }

  private renderDefinition(): TemplateResult | typeof nothing {
    const definition = this.follower.update?.definition ?? "";
    return definition === "" ? nothing : html`<details><summary>${msg("Definition")}</summary><pre tabindex="0">${definition}</pre></details>`;
  }

  private facts(nowMs: number): TopicFacts {
    const age = this.follower.flow.ageMs(nowMs);
    return {
      topic: this.topic,
      state: this.follower.stateAt(nowMs, this.online),
      why: this.follower.problem,
      age: age === null ? null : age / 1000,
    };
  }

  private readonly onPlot = (event: CustomEvent<string>): void => {
    this.plots.toggle(event.detail);
    this.requestUpdate();
  };

  private mayMakeSignals(): boolean {
    return isSiteAdmin(this.session.store?.person, this.site);
  }

  private makeSignal(field: string, text = false): void {
    this.wanted = { topic: this.topic, type: this.follower.update?.type ?? this.type, field, text };
  }

  private readonly onMakeSignal = ({ detail }: CustomEvent<FieldChoice>): void => {
    this.makeSignal(detail.path, detail.text);
  };

  private readonly endSignal = (): void => {
    this.wanted = null;
  };

  private readonly togglePause = (): void => {
    const { message, tree } = this.follower;
    this.held = this.held !== null || message === null ? null : { message, tree };
  };

  private readonly chooseView = (event: CustomEvent<string>): void => {
    this.view = event.detail === "tile" ? "tile" : "tree";
  };

  private readonly onSearch = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.search = event.target.value;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-topic": TopicDetail;
  }
}
