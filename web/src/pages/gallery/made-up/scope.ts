/** What stands inside is on a page of a hub that is made up, and is shown as such a hub says it. */

import { ContextProvider } from "@lit/context";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { CommandClient } from "../../../controllers/drive/command-client.js";
import { PaintScheduler } from "../../../elements/chart/paint-scheduler.js";
import { Trace } from "../../../series/trace.js";
import { Alarms } from "../../../state/alarms.js";
import {
  alarmsContext, apiContext, connectionContext, deviceHoldersContext, interlocksContext, liveContext, reachContext, robotNewsContext, sitesContext, socketsContext,
} from "../../../state/contexts.js";
import { DeviceHolders } from "../../../state/device-holders.js";
import { DeviceReachability } from "../../../state/device-reachability.js";
import { Interlocks } from "../../../state/interlocks.js";
import { LiveValues } from "../../../state/live-values.js";
import { RobotState } from "../../../state/robot-state.js";
import { Sites } from "../../../state/sites.js";
import type { BoardTileContext, TileSamples } from "../../../tiles/board/board-tile-entry.js";
import { PictureTimes } from "../../../tiles/board/picture-times.js";
import { Connection } from "../../../wire/connection.js";
import { HubApi } from "../../../wire/hub-api.js";
import { answerAs, OLD_S, type Mood } from "./answers.js";
import { DETAIL, EXTENSIONS, readingAt, SITE } from "./site.js";
import { socketsAs } from "./sockets.js";

const SPAN_S = 300;

/** Charts of a mood: the last minutes, drawn from the same readings as the newest values. */
class MadeSamples implements TileSamples {
  private readonly traces = new Map<string, { readonly trace: Trace; readonly gaps: readonly [] }>();

  constructor(private readonly mood: Mood) {}

  channelOf(address: string): { readonly trace: Trace; readonly gaps: readonly [] } {
    const known = this.traces.get(address);
    if (known !== undefined) return known;
    const made = { trace: new Trace(SPAN_S * 1e6, 5e6), gaps: [] as const };
    if (this.mood !== "empty" && this.mood !== "barred") {
      const last = Date.now() / 1000 - this.lateS();
      for (let s = last - SPAN_S + this.lateS(); s <= last; s += 1) {
        const value = readingAt(address, s);
        if (typeof value === "number") made.trace.addSample(Math.round(s * 1e6), value);
      }
    }
    this.traces.set(address, made);
    return made;
  }

  ageS(address: string): number {
    const { trace } = this.channelOf(address);
    return trace.length === 0 ? Number.NaN : Math.max(0, this.lateS());
  }

  currentWindow(): { readonly fromUs: number; readonly toUs: number } {
    const toUs = Date.now() * 1000;
    return { fromUs: toUs - SPAN_S * 1e6, toUs };
  }

  private lateS(): number {
    return this.mood === "live" ? 0 : OLD_S;
  }
}

/** A page of a made-up hub: its stores are the real ones, over sockets and answers that are made up. */
class MadePage {
  readonly sockets: (url: string) => WebSocket;
  readonly api: HubApi;
  readonly connection: Connection;
  readonly alarms: Alarms;
  readonly holders: DeviceHolders;
  readonly locks: Interlocks;
  readonly live: LiveValues;
  readonly reach: DeviceReachability;
  readonly robots: RobotState;
  readonly sites: Sites;
  readonly context: BoardTileContext;

  constructor(mood: Mood) {
    this.sockets = socketsAs(mood);
    this.api = new HubApi(answerAs(mood));
    this.connection = new Connection({ url: "ws://gallery/ws", openSocket: this.sockets });
    this.alarms = new Alarms(this.connection);
    this.holders = new DeviceHolders(this.connection);
    this.locks = new Interlocks(this.connection);
    this.live = new LiveValues(this.connection);
    this.reach = new DeviceReachability(this.connection);
    this.robots = new RobotState(this.connection);
    this.sites = new Sites(this.api);
    const line = new CommandClient(this.connection, SITE);
    const online = mood !== "away";
    this.context = {
      site: SITE, zone: DETAIL.zone, detail: { ...DETAIL, online }, device: DETAIL.devices[0] ?? null, online, linked: online, past: null,
      feed: new MadeSamples(mood), painter: new PaintScheduler(), line, pictures: new PictureTimes(), extensions: EXTENSIONS,
    };
    line.open();
    this.connection.start();
  }
}

const pages = new Map<Mood, MadePage>();

function pageOf(mood: Mood): MadePage {
  const page = pages.get(mood) ?? new MadePage(mood);
  pages.set(mood, page);
  return page;
}

/** What a tile of such a page is handed. */
export function madeContext(mood: Mood): BoardTileContext {
  return pageOf(mood).context;
}

/** @slot - a tile; it is as large as on a board */
@customElement("t-made-scope")
export class MadeScope extends LitElement {
  static override styles = css`
    :host {
      display: block;
      block-size: calc(var(--rows, 4) * 5rem - 1rem);
      min-inline-size: 0;
    }
    @media (max-width: 45rem) {
      :host {
        block-size: calc(var(--phone-rows, 4) * 5rem - 1rem);
      }
    }
  `;

  /** Said before anything stands inside: whoever asks then gets what is made up. */
  @property({ attribute: false })
  set mood(mood: Mood) {
    const page = pageOf(mood);
    new ContextProvider(this, { context: alarmsContext, initialValue: page.alarms });
    new ContextProvider(this, { context: apiContext, initialValue: page.api });
    new ContextProvider(this, { context: connectionContext, initialValue: page.connection });
    new ContextProvider(this, { context: deviceHoldersContext, initialValue: page.holders });
    new ContextProvider(this, { context: interlocksContext, initialValue: page.locks });
    new ContextProvider(this, { context: liveContext, initialValue: page.live });
    new ContextProvider(this, { context: reachContext, initialValue: page.reach });
    new ContextProvider(this, { context: robotNewsContext, initialValue: page.robots });
    new ContextProvider(this, { context: sitesContext, initialValue: page.sites });
    new ContextProvider(this, { context: socketsContext, initialValue: page.sockets });
  }

  override render(): TemplateResult {
    return html`<slot></slot>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-made-scope": MadeScope;
  }
}
