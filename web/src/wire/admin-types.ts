/** Shapes of accounts, roles, gateways and the audit log, by the names the pages use. */

export type {
  AuditChain as AuditCheck,
  AuditList as AuditPage,
  AuditRow,
  ChannelStorageShape as ChannelStorage,
  CodeShape as CodeMade,
  FactorOffer,
  GatewayList,
  GatewayShape as GatewayRow,
  NewToken as TokenMade,
  OpenCodeShape as CodeRow,
  OutlookShape as Outlook,
  PersonShape as PersonRow,
  RoleShape as RoleRow,
  SessionShape as SessionRow,
  StorageShape as StorageUse,
  TokenShape as TokenRow,
} from "../generated/api.js";
