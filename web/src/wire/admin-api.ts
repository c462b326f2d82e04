/** What an admin may ask of the hub: people, roles, gateways, storage, the audit log. */

import type { AuditChain, AuditList, ClientDriverAsk, ClientProtocolList, CodeShape, DisplayList, DisplayShape, GatewayList, HubList, NewDisplay, NewWitnessedHub, OutlookShape, PermissionShape, PersonChange, PersonList, PersonShape, ReleaseList, RoleList, RoleShape, RolloutAsk, SecondGatewayAsk, StorageShape, WitnessedHubList, WitnessedHubShape } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

const itemUrl = (path: string, id: string, more = ""): string => `/api/${path}/${encodeURIComponent(id)}${more}`;

export class AdminApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  async people(): Promise<readonly PersonShape[]> {
    return (await this.hub.request<PersonList>("GET", "/api/people")).people;
  }

  addPerson(name: string, password: string, role: string): Promise<PersonShape> {
    return this.hub.request("POST", "/api/people", { name, password, role });
  }

  changePerson(person: string, change: PersonChange): Promise<PersonShape> {
    return this.hub.request("PATCH", itemUrl("people", person), change);
  }

  async displays(): Promise<readonly DisplayShape[]> {
    return (await this.hub.request<DisplayList>("GET", "/api/displays")).displays;
  }

  addDisplay(name: string, sites: readonly string[]): Promise<NewDisplay> {
    return this.hub.request("POST", "/api/displays", { name, sites });
  }

  /** Its screen goes dark at once. */
  async revokeDisplay(display: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("displays", display));
  }

  async removePerson(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person));
  }

  async endSessions(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person, "/sessions"));
  }

  async removeFactor(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person, "/factor"));
  }

  /** The provider signs them in no more; they have a password. */
  async disconnectPerson(person: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("people", person, "/oidc"));
  }

  /** Other hubs that leave signed heads of their audit logs here. */
  async witnessedHubs(): Promise<readonly WitnessedHubShape[]> {
    return (await this.hub.request<WitnessedHubList>("GET", "/api/audit/hubs")).hubs;
  }

  addWitnessedHub(name: string, keepDays: number): Promise<NewWitnessedHub> {
    return this.hub.request("POST", "/api/audit/hubs", { name, keep_days: keepDays });
  }

  async removeWitnessedHub(hub: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("audit/hubs", hub));
  }

  async roles(): Promise<readonly RoleShape[]> {
    return (await this.hub.request<RoleList>("GET", "/api/roles")).roles;
  }

  async addRole(name: string, permissions: readonly PermissionShape[]): Promise<void> {
    await this.hub.request("POST", "/api/roles", { name, permissions });
  }

  async changeRole(role: string, name: string, permissions: readonly PermissionShape[]): Promise<void> {
    await this.hub.request("PUT", itemUrl("roles", role), { name, permissions });
  }

  /** Who has the role and no second factor sets one up before anything else. */
  async requireFactor(role: string, required: boolean): Promise<void> {
    await this.hub.request("PUT", itemUrl("roles", role, "/factor"), { required });
  }

  async removeRole(role: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("roles", role));
  }

  gateways(): Promise<GatewayList> {
    return this.hub.request("GET", "/api/gateways");
  }

  makeCode(site: string, name: string): Promise<CodeShape> {
    return this.hub.request("POST", "/api/gateways/codes", name === "" ? { site } : { site, name });
  }

  async withdrawCode(code: string): Promise<void> {
    await this.hub.request("DELETE", itemUrl("gateways/codes", code));
  }

  /** Its key is void and its link closed at once. */
  async revokeGateway(gateway: string): Promise<void> {
    await this.hub.request("POST", itemUrl("gateways", gateway, "/revoke"), {});
  }

  /** @param device empty: the link between gateway and hub; else the gateway's own to that device */
  async reconnect(gateway: string, device = ""): Promise<void> {
    await this.hub.request("POST", itemUrl("gateways", gateway, "/reconnect"), { device });
  }

  /** Decides between two gateways with one key; the other one waits, and STOP reaches both. */
  async settleSecondGateway(gateway: string, stays: SecondGatewayAsk["stays"]): Promise<void> {
    await this.hub.request("POST", itemUrl("gateways", gateway, "/second"), { stays });
  }

  clientProtocols(): Promise<ClientProtocolList> {
    return this.hub.request("GET", "/api/client-protocols");
  }

  /** Connections that are not allowed any more are closed at once. */
  async setClientProtocol(protocol: string, open: boolean, origins: readonly string[]): Promise<void> {
    await this.hub.request("PUT", itemUrl("client-protocols", protocol), { open, origins });
  }

  async setClientDriver({ person, site, device }: Omit<ClientDriverAsk, "allowed">, allowed: boolean): Promise<void> {
    await this.hub.request("PUT", "/api/client-drivers", { person, site, device, allowed });
  }

  /** @param search the filter, as in the address; see `pages/audit/query.ts` */
  audit(search: string, signal?: AbortSignal): Promise<AuditList> {
    return this.hub.request("GET", `/api/audit?${search}`, undefined, { signal });
  }

  /** The hubs that are one with this one; of one that is alone, that it is. */
  hubs(): Promise<HubList> {
    return this.hub.request("GET", "/api/hubs");
  }

  /** Releases of the gateways' own software, who takes them, and the last that was handed out. */
  releases(): Promise<ReleaseList> {
    return this.hub.request("GET", "/api/releases");
  }

  async beginRollout(asked: RolloutAsk): Promise<void> {
    await this.hub.request("POST", "/api/rollouts", asked);
  }

  async stopRollout(): Promise<void> {
    await this.hub.request("POST", "/api/rollouts/stop", {});
  }

  /** One ZIP file for whoever helps; takes as long as the hub needs to look at its machine. */
  supportBundle(): Promise<ArrayBuffer> {
    return this.hub.request("POST", "/api/support-bundle", {}, { bytes: true });
  }

  storage(): Promise<StorageShape> {
    return this.hub.request("GET", "/api/storage");
  }

  /** Whether there is room for what comes; cheap, and a few minutes old. */
  storageForecast(): Promise<OutlookShape> {
    return this.hub.request("GET", "/api/storage/outlook");
  }

  checkAudit(): Promise<AuditChain> {
    return this.hub.request("GET", "/api/audit/verify");
  }
}
