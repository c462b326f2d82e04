/** A robot's diagnostics as they come on a raw topic: followed while the tile is looked at. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { TickerController } from "../../controllers/ticker.js";
import { TopicFollower, type TopicState } from "../../controllers/topic-follower.js";
import { base, raisedBox } from "../../elements/base/base-style.js";
import { renderTopicStatus, renderTopicTrouble, type TopicFacts } from "../../elements/topic/topic-state.js";
import { DiagnosticsBook } from "../../series/diagnostics.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { topicPagePath } from "../../state/router.js";
import { ALL_MESSAGES } from "../../topics/shared-topics.js";
import "../../elements/topic/diagnostics-tree.js";

/** What stands in the place of the tree, and not above it. */
const INSTEAD: readonly TopicState[] = ["loading", "waiting", "forbidden", "unrecorded"];

@customElement("t-diagnostics-tile")
export class DiagnosticsTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        align-content: start;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      :host(:not([bare])) {
        padding: var(--t-space-4);
        ${raisedBox}
      }
      .head {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        justify-content: space-between;
        gap: var(--t-space-1) var(--t-space-4);
      }
      h3 a {
        color: inherit;
      }
    `,
  ];

  @property() site = "";
  @property() topic = "";
  @property({ type: Boolean }) online = false;
  /** Without a box and a head of its own. */
  @property({ type: Boolean, reflect: true }) bare = false;

  /** The past moment that is shown; null for now. */
  @property({ attribute: false }) past: PastBoard | null = null;
  @property() zone = "UTC";

  private readonly book = new DiagnosticsBook();
  private readonly follower = new TopicFollower(
    this,
    (tree, nowMs) => {
      this.book.addMessage(tree, nowMs);
    },
    () => {
      this.book.clear();
    },
  );

  constructor() {
    super();
    new TickerController(this);
  }

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("site") || changed.has("topic")) this.book.clear();
    this.follower.follow(this.site, this.topic, ALL_MESSAGES, this.past);
  }

  override render(): TemplateResult {
    const nowMs = this.follower.nowMs();
    const facts = this.facts(nowMs);
    return html`
      ${this.bare
        ? nothing
        : html`<div class="head">
            <h3><a href=${topicPagePath(this.site, this.topic)}>${msg("Diagnostics")}</a> <code class="muted">${this.topic}</code></h3>
            ${renderTopicStatus(facts)}
          </div>`}
      ${this.bare ? nothing : renderTopicTrouble(facts)}
      ${INSTEAD.includes(facts.state) || (this.book.size === 0 && facts.age === null) ? nothing : html`<t-diagnostics .root=${this.book.treeAt(nowMs)} .left=${this.book.leftOut}></t-diagnostics>`}
    `;
  }

  private facts(nowMs: number): TopicFacts {
    const age = this.follower.flow.ageMs(nowMs);
    return {
      topic: this.topic,
      state: this.follower.stateAt(nowMs, this.online),
      why: this.follower.problem,
      age: age === null ? null : age / 1000,
      past: this.past,
      zone: this.zone,
    };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-diagnostics-tile": DiagnosticsTile;
  }
}
