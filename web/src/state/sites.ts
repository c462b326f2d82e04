/** The sites this person may see, kept up to date by the hub's news. */

import { msg } from "@lit/localize";
import type { SiteUpdate } from "../generated/wire.js";
import type { SiteShape, SiteSummary } from "../generated/api.js";
import type { HubApi } from "../wire/hub-api.js";
import { Store } from "./store.js";

export type LoadState = "idle" | "loading" | "ready" | "failed";

/** With more sites than this (each tells of itself every few seconds), pages are told of news together, so often (ms). */
const MANY = 50;
const TOGETHER_MS = 500;
/** While sites are missing from the list, it is asked for again so often. */
const MISSING_MS = 5000;

/** Letters without case and accents: who looks for "Pena" finds "Peña". */
export function foldedText(text: string): string {
  return text.normalize("NFD").replaceAll(/\p{M}/gu, "").toLowerCase();
}

/** The same sites; where two have one name, each says its id behind it. */
function withUniqueNames(rows: readonly SiteSummary[]): readonly SiteSummary[] {
  const counts = new Map<string, number>();
  for (const { name } of rows) counts.set(foldedText(name), (counts.get(foldedText(name)) ?? 0) + 1);
  return rows.map((row) => ((counts.get(foldedText(row.name)) ?? 0) > 1 ? { ...row, name: `${row.name} (${row.site})` } : row));
}

export class Sites extends Store {
  private rows: readonly SiteSummary[] = [];
  private loading: LoadState = "idle";
  private problem: unknown = null;
  private away: readonly string[] = [];
  private asking: ReturnType<typeof setTimeout> | undefined;
  private telling: ReturnType<typeof setTimeout> | undefined;
  private readonly details = new Map<string, { catalogue: string; detail: Promise<SiteShape> }>();
  private readonly catalogues = new Map<string, string>();

  constructor(private readonly api: HubApi) {
    super();
  }

  /** No two have one name. */
  get list(): readonly SiteSummary[] {
    return this.rows;
  }

  get status(): LoadState {
    return this.loading;
  }

  /** What went wrong with the last load; null when nothing did. */
  get renderError(): unknown {
    return this.problem;
  }

  /** Hubs that have sites of which nothing is known now, by their names; empty while all can be reached. */
  get missing(): readonly string[] {
    return this.away;
  }

  /** Zone for times that belong to no site: the first site's. */
  get zone(): string {
    return this.rows[0]?.zone ?? "UTC";
  }

  /** Zone of a site; of the first one where the site is not known. */
  zoneOf(site: string): string {
    return this.siteRow(site)?.zone ?? this.zone;
  }

  siteRow(site: string): SiteSummary | undefined {
    return this.rows.find((row) => row.site === site);
  }

  /** Names the newest description of a site that the hub has told of; empty before it did. */
  catalogueOf(site: string): string {
    return this.catalogues.get(site) ?? "";
  }

  /** Asks for the list. The old one stays on screen meanwhile. */
  async load(): Promise<void> {
    if (this.loading !== "ready") this.loading = "loading";
    this.notifyWatchers();
    try {
      const { rows, missing } = await this.api.siteRows();
      this.rows = withUniqueNames(missing.length === 0 ? rows : this.withKeptRows(rows));
      this.away = missing;
      clearTimeout(this.asking);
      if (missing.length > 0) this.asking = setTimeout(() => void this.load(), MISSING_MS);
      this.loading = "ready";
      this.problem = null;
    } catch (error) {
      this.loading = "failed";
      this.problem = error;
    }
    this.notifyWatchers();
  }

  /**
   * The description of a site, from memory while it has not changed.
   *
   * @throws Refused, Unreachable
   */
  loadDetail(site: string): Promise<SiteShape> {
    const catalogue = this.catalogueOf(site);
    const held = this.details.get(site);
    if (held?.catalogue === catalogue) return held.detail;
    const detail = this.api.site(site);
    this.details.set(site, { catalogue, detail });
    detail.catch(() => {
      // A failure is not worth remembering: the next asker tries again.
      if (this.details.get(site)?.detail === detail) this.details.delete(site);
    });
    return detail;
  }

  /** Descriptions are asked for anew: the person sees them otherwise now, in other units, say. */
  forgetDetails(): void {
    this.details.clear();
    this.notifyWatchers();
  }

  /** Takes in that a site came, went, or changed its description. */
  applyUpdate(news: SiteUpdate): void {
    if (news.catalogue !== "") this.catalogues.set(news.site, news.catalogue);
    const row = this.siteRow(news.site);
    if (row === undefined) {
      // A site we have not heard of: the list has grown, or rights have changed.
      if (this.loading === "ready") void this.load();
      return;
    }
    this.rows = this.rows.map((other) =>
      other === row
        ? {
            ...row,
            online: news.online,
            since_us: news.since_us,
            why: news.why,
            loop_ms: news.loop_ms,
            skew_ms: news.skew_ms,
            rival_us: news.rival_us,
            last_seen_us: news.online ? row.last_seen_us : Math.max(row.last_seen_us, news.since_us),
          }
        : other,
    );
    this.tellOfNews();
  }

  /** Sites that were listed and are missing now stay, as ones of which nothing is known. */
  private withKeptRows(rows: readonly SiteSummary[]): readonly SiteSummary[] {
    const listed = new Set(rows.map(({ site }) => site));
    const kept = this.rows.filter(({ site }) => !listed.has(site));
    const why = msg("the hub that has this site cannot be reached; it is tried again");
    return [...rows, ...kept.map((row) => ({ ...row, online: false, why }))].sort((a, b) => (a.site < b.site ? -1 : 1));
  }

  private tellOfNews(): void {
    if (this.rows.length <= MANY) {
      this.notifyWatchers();
      return;
    }
    this.telling ??= setTimeout(() => {
      this.telling = undefined;
      this.notifyWatchers();
    }, TOGETHER_MS);
  }

  /** Forgets all: another person may see other things. */
  clear(): void {
    this.rows = [];
    this.away = [];
    clearTimeout(this.asking);
    this.loading = "idle";
    this.problem = null;
    this.details.clear();
    this.catalogues.clear();
    this.notifyWatchers();
  }
}
