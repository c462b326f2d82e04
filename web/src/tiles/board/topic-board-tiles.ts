/** Raw topics as tiles: the newest message as a tree, and diagnostics. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { TickerController } from "../../controllers/ticker.js";
import { TopicFollower } from "../../controllers/topic-follower.js";
import { base } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { renderTopicStatus, renderTopicTrouble, type TopicFacts } from "../../elements/topic/topic-state.js";
import { topicPagePath } from "../../state/router.js";
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
  @state() private search = "";

  private readonly follower = new TopicFollower(this);

  constructor() {
    super();
    new TickerController(this);
  }

  protected override willUpdate(): void {
    this.follower.follow(this.context?.site ?? "", this.topic, RATE);
  }

  override render(): TemplateResult {
    const nowMs = performance.now();
    const age = this.follower.flow.ageMs(nowMs);
    const facts: TopicFacts = {
      topic: this.topic,
      state: this.follower.stateAt(nowMs, this.context?.online ?? false),
      why: this.follower.problem,
      age: age === null ? null : age / 1000,
    };
    const { tree } = this.follower;
    return html`<div class="tools">
        <input type="search" aria-label=${`Search ${this.topic}`} placeholder="Search a field" .value=${this.search} @input=${this.onSearch} />
        ${renderTopicStatus(facts)} <a href=${topicPagePath(this.context?.site ?? "", this.topic)}>Topic</a>
      </div>
      ${renderTopicTrouble(facts)} ${tree === undefined || facts.state === "forbidden" ? nothing : html`<t-message-tree .value=${tree} .search=${this.search}></t-message-tree>`}`;
  }

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
    return html`<t-diagnostics-tile .site=${this.context?.site ?? ""} .topic=${this.topic} .online=${this.context?.online ?? false}></t-diagnostics-tile>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-topic": TopicBoardTile;
    "t-tile-diagnostics": DiagnosticsBoardTile;
  }
}
