/** Which cameras of a site are being filmed: asked once for all buttons of a page. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import { FilmsApi } from "../wire/films-api.js";
import type { FilmListShape } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";

/** Who may film sees within this time that somebody else has begun (ms). */
const EVERY_MS = 3000;
/** Who may not, or not now, is asked for this often: rights and gateways change (ms). */
const SELDOM_MS = 30_000;

/** One site; asks while somebody listens. */
class SiteRecording {
  readonly listeners = new Set<() => void>();
  list: FilmListShape | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private run = 0;

  constructor(
    private readonly api: HubApi,
    private readonly site: string,
  ) {}

  async loadStatus(): Promise<void> {
    clearTimeout(this.timer);
    const run = ++this.run;
    try {
      const list = await new FilmsApi(this.api).recordingStatus(this.site);
      if (run !== this.run) return;
      this.list = list;
    } catch {
      // The page says by itself that the hub is away; here the next answer counts.
      if (run !== this.run) return;
    }
    for (const listener of this.listeners) listener();
    this.stopPolling();
  }

  stopPolling(): void {
    clearTimeout(this.timer);
    if (this.listeners.size === 0) return;
    this.timer = setTimeout(() => {
      if (document.hidden) this.stopPolling();
      else void this.loadStatus();
    }, this.list?.may_film === true ? EVERY_MS : SELDOM_MS);
  }
}

const sites = new Map<string, SiteRecording>();

export class FilmRecordingController implements ReactiveController {
  private watched: SiteRecording | null = null;
  private site = "";

  constructor(private readonly host: ReactiveControllerHost) {
    host.addController(this);
  }

  get list(): FilmListShape | null {
    return this.watched?.list ?? null;
  }

  /** Call it from `willUpdate`. */
  setSite(api: HubApi | undefined, site: string): void {
    if (api === undefined || site === "" || site === this.site) return;
    this.hostDisconnected();
    this.site = site;
    let watched = sites.get(site);
    if (watched === undefined) sites.set(site, (watched = new SiteRecording(api, site)));
    this.watched = watched;
    watched.listeners.add(this.requestHostUpdate);
    if (watched.listeners.size === 1) void watched.loadStatus();
  }

  refresh(): void {
    void this.watched?.loadStatus();
  }

  hostDisconnected(): void {
    const { watched } = this;
    if (watched === null) return;
    watched.listeners.delete(this.requestHostUpdate);
    if (watched.listeners.size === 0) sites.delete(this.site);
    watched.stopPolling();
    this.watched = null;
    this.site = "";
  }

  private readonly requestHostUpdate = (): void => {
    this.host.requestUpdate();
  };
}
