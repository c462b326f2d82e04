/** The raw topics that a site's description offers and that have a tile of their own. */

import { consume } from "@lit/context";
import { css, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import type { TopicShape, TopicTable } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import type { HubApi } from "../../wire/hub-api.js";
import { TopicsApi } from "../../topics/topics-api.js";
import { topicTile } from "../catalog.js";

/** Topics come and go; it is looked so often whether there are others (ms). */
const AGAIN_MS = 15_000;
const MOST = 3;

@customElement("t-topic-tiles")
export class TopicTiles extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      :host(:not([filled])) {
        display: none;
      }
    `,
  ];

  @property() site = "";
  @property({ type: Boolean }) online = false;
  /** There is something to show. */
  @property({ type: Boolean, reflect: true }) filled = false;

  @consume({ context: apiContext }) private api: HubApi | undefined;
  private readonly topics = new LoadController<TopicTable>(this);
  private timer: ReturnType<typeof setInterval> | undefined;
  /** Those of before, while the list cannot be had. */
  private shown: readonly TopicShape[] = [];

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(this.topics.invalidate, AGAIN_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
  }

  protected override willUpdate(): void {
    const { api, site } = this;
    if (api === undefined || site === "") return;
    this.topics.load(`${site} ${String(this.online)}`, () => new TopicsApi(api, site).listTopics());
    const { result } = this.topics;
    if (result.state === "ready") this.shown = offeredTiles(result.value.topics);
    this.filled = this.shown.length > 0;
    for (const { type } of this.shown) void topicTile(type)?.load();
  }

  override render(): unknown {
    return repeat(
      this.shown,
      ({ topic }) => topic,
      ({ topic, type }): TemplateResult | typeof nothing => topicTile(type)?.render({ site: this.site, topic, online: this.online }) ?? nothing,
    );
  }
}

/** Topics with a tile that a rule of the description names; of diagnostics the aggregated ones first, which say the same in better order. */
export function offeredTiles(topics: readonly TopicShape[]): readonly TopicShape[] {
  const found = topics.filter(({ described, problem, type }) => described && problem === "" && topicTile(type) !== null);
  return [...found].sort((a, b) => Number(b.topic.includes("agg")) - Number(a.topic.includes("agg")) || a.topic.localeCompare(b.topic)).slice(0, MOST);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-topic-tiles": TopicTiles;
  }
}
