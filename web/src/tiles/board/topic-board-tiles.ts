/** Raw topics as tiles: the newest message as a tree, and diagnostics. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { TopicFollower } from "../../controllers/topic-follower.js";
import { base } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { renderTopicStatus, renderTopicTrouble, type TopicFacts } from "../../elements/topic/topic-state.js";
import type { FieldChoice } from "../../elements/topic/message-tree.js";
import { routerContext, sessionContext } from "../../state/contexts.js";
import { isSiteAdmin } from "../../state/rights.js";
import { topicPagePath } from "../../state/router.js";
import { FieldTraces } from "../../topics/field-traces.js";
import "../../elements/topic/field-plot.js";
import "../../elements/topic/message-tree.js";
import "../topic/diagnostics-tile.js";
import type { BoardTileContext } from "./board-tile-entry.js";

/** Messages a second: more than an eye reads. */
const RATE = 5;

@customElement("t-tile-topic")
export class TopicBoardTile extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
        gap: var(--t-space-2);
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
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property() topic = "";
  /** Fields that are plotted from the beginning. */
  @property({ attribute: false }) fields: readonly string[] = [];
  @state() private search = "";

  private readonly router = new ContextStoreController(this, routerContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly plots = new FieldTraces();
  private plotted = "";
  private readonly follower = new TopicFollower(
    this,
    (tree, nowMs) => {
      this.plots.addMessage(tree, nowMs);
    },
    () => {
      this.plots.clear();
    },
  );

  constructor() {
    super();
    new TickerController(this);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("topic")) this.plots.clear();
    // The same list comes anew with each drawing of the board: only another one is chosen.
    const wanted = JSON.stringify(this.fields);
    if (wanted !== this.plotted) this.plots.choose(this.fields);
    this.plotted = wanted;
    this.follower.follow(this.context?.site ?? "", this.topic, RATE, this.context?.past ?? null);
  }

  override render(): TemplateResult {
    const nowMs = this.follower.nowMs();
    const age = this.follower.flow.ageMs(nowMs);
    const facts: TopicFacts = {
      topic: this.topic,
      state: this.follower.stateAt(nowMs, this.context?.online ?? false),
      why: this.follower.problem,
      age: age === null ? null : age / 1000,
      past: this.context?.past ?? null,
      zone: this.context?.zone ?? "UTC",
    };
    const hidden = facts.state === "forbidden" || facts.state === "unrecorded";
    const { tree } = this.follower;
    return html`<div class="tools">
        <input type="search" aria-label=${msg(str`Search ${this.topic}`)} placeholder=${msg("Search a field")} .value=${this.search} @input=${this.onSearch} />
        ${renderTopicStatus(facts)} <a href=${topicPagePath(this.context?.site ?? "", this.topic)}>${msg("Topic")}</a>
      </div>
      ${renderTopicTrouble(facts)}
      ${hidden ? nothing : html`<t-field-plot .traces=${this.plots.traces} .nowMs=${nowMs} @t-plot=${this.onPlot}></t-field-plot>`}
      ${tree === undefined || hidden
        ? nothing
        : html`<t-message-tree .value=${tree} .search=${this.search} .plotted=${this.plots.paths} ?signals=${this.mayMakeSignals()} @t-plot=${this.onPlot} @t-make-signal=${this.onMakeSignal}></t-message-tree>`}`;
  }

  private readonly onPlot = (event: CustomEvent<string>): void => {
    this.plots.toggle(event.detail);
    this.requestUpdate();
  };

  /** Numbers only: a tile's own page knows what holds words. */
  private mayMakeSignals(): boolean {
    return this.context?.past == null && isSiteAdmin(this.session.store?.person, this.context?.site ?? "");
  }

  private readonly onMakeSignal = ({ detail }: CustomEvent<FieldChoice>): void => {
    this.router.store?.navigate(topicPagePath(this.context?.site ?? "", this.topic, detail.text ? "" : detail.path));
  };

  private readonly onSearch = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.search = event.target.value;
  };
}

@customElement("t-tile-diagnostics")
export class DiagnosticsBoardTile extends LitElement {
  static override styles = css`
    :host {
      display: block;
    }
    t-diagnostics-tile {
      padding: 0;
      border: 0;
      box-shadow: none;
    }
  `;

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property() topic = "";

  override render(): TemplateResult {
    return html`<t-diagnostics-tile .site=${this.context?.site ?? ""} .topic=${this.topic} .online=${this.context?.online ?? false} .past=${this.context?.past ?? null} zone=${this.context?.zone ?? "UTC"}></t-diagnostics-tile>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-topic": TopicBoardTile;
    "t-tile-diagnostics": DiagnosticsBoardTile;
  }
}
