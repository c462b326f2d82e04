/** What may be asked of a site's nights, of its proposals and of the requests for them. */

import type {
  ForecastShape, GroupAsk, GroupShape, ImportAnswer, ImportAsk, NightAnswer, SiteNightShape, ProposalAsk, ProposalChange, ProposalList, ProposalRole, RequestDetail, RequestList,
  ValidationShape, WeekShape,
} from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

/** What is done with a group that is there. */
export type GroupStep = "submit" | "withdraw" | "approve" | "cancel" | "retry";

export class ObservingApi {
  constructor(
    private readonly hub: Pick<HubApi, "request">,
    private readonly site: string,
  ) {}

  nightOverview(): Promise<SiteNightShape> {
    return this.hub.request("GET", this.url("night"));
  }

  /** Tonight as it is planned with what waits, and why the rest is not in it. */
  nightForecast(): Promise<ForecastShape> {
    return this.hub.request("GET", this.url("night/forecast"));
  }

  weekForecast(): Promise<WeekShape> {
    return this.hub.request("GET", this.url("night/week"));
  }

  /** @param untilUs 0: until somebody disarms it */
  armNight(untilUs: number): Promise<NightAnswer> {
    return this.hub.request("POST", this.url("night/arm"), { until_us: untilUs });
  }

  /** Asks for a few short frames and arms, where the site is a simulator; a whole night of one that lives faster. */
  beginShortNight(): Promise<NightAnswer> {
    return this.hub.request("POST", this.url("night/short"));
  }

  disarmNight(why: string): Promise<NightAnswer> {
    return this.hub.request("POST", this.url("night/disarm"), { why });
  }

  listProposals(): Promise<ProposalList> {
    return this.hub.request("GET", this.url("proposals"));
  }

  async addProposal(asked: ProposalAsk): Promise<void> {
    await this.hub.request("POST", this.url("proposals"), asked);
  }

  async changeProposal(proposal: string, asked: ProposalChange): Promise<void> {
    await this.hub.request("PUT", this.url(`proposals/${encodeURIComponent(proposal)}`), asked);
  }

  async removeProposal(proposal: string): Promise<void> {
    await this.hub.request("DELETE", this.url(`proposals/${encodeURIComponent(proposal)}`));
  }

  /** @param role null: no member any more */
  async setMember(proposal: string, name: string, role: ProposalRole | null): Promise<void> {
    await this.hub.request("PUT", this.url(`proposals/${encodeURIComponent(proposal)}/members`), { name, role });
  }

  findRequests(query: string): Promise<RequestList> {
    return this.hub.request("GET", this.url(`requests?${query}`));
  }

  requestDetail(id: string): Promise<RequestDetail> {
    return this.hub.request("GET", this.url(`requests/${encodeURIComponent(id)}`));
  }

  addGroup(asked: GroupAsk): Promise<GroupShape> {
    return this.hub.request("POST", this.url("request-groups"), asked);
  }

  /** What would become of a group; keeps nothing. */
  validateGroup(asked: GroupAsk): Promise<ValidationShape> {
    return this.hub.request("POST", this.url("request-groups/validate"), asked);
  }

  /** What another program's file asks; keeps nothing. */
  importFile(asked: ImportAsk): Promise<ImportAnswer> {
    return this.hub.request("POST", this.url("request-groups/import"), asked);
  }

  replaceGroup(group: string, asked: GroupAsk): Promise<GroupShape> {
    return this.hub.request("PUT", this.url(`request-groups/${encodeURIComponent(group)}`), asked);
  }

  changeGroup(group: string, step: GroupStep, why = ""): Promise<GroupShape> {
    return this.hub.request("POST", this.url(`request-groups/${encodeURIComponent(group)}/${step}`), { why });
  }

  private url(more: string): string {
    return `/api/sites/${encodeURIComponent(this.site)}/${more}`;
  }
}
